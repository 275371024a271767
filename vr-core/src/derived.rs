//! Structures that are derived from a volume once and kept with it.

use std::any::{Any, TypeId};
use std::collections::HashMap;
use std::fmt;
use std::hash::Hash;
use std::sync::{Arc, Mutex, OnceLock};

use crate::parallel::locked;

/// Structures derived from a volume, each made once, when first asked for: one for each type and key.
///
/// A volume does not know the structures that renderers derive from it (ranges of blocks, run-length encodings): it keeps them.
///
/// # Examples
/// ```
/// use vr_core::Derived;
///
/// let derived = Derived::default();
/// let blocks = |edge: usize| derived.get(edge, || vec![0u8; 64 / edge]);
/// assert_eq!(blocks(8).len(), 8);
/// assert_eq!(blocks(4).len(), 16);
/// assert!(std::sync::Arc::ptr_eq(&blocks(8), &blocks(8)), "made once");
/// ```
#[derive(Default)]
pub struct Derived(Mutex<HashMap<TypeId, Box<dyn Any + Send>>>);

/// Structures of one type, by keys of one type. Cells are shared, so that the map is not locked while one is made.
type ByKey<K, T> = HashMap<K, Arc<OnceLock<Arc<T>>>>;

impl Derived {
    /// Returns the structure of a key, making it if it is not there. Threads that ask for the same one meanwhile wait for it.
    pub fn get<K, T>(&self, key: K, make: impl FnOnce() -> T) -> Arc<T>
    where
        K: Eq + Hash + Send + 'static,
        T: Send + Sync + 'static,
    {
        let cell = {
            let mut kinds = locked(&self.0);
            let kind = kinds.entry(TypeId::of::<ByKey<K, T>>()).or_insert_with(|| Box::new(ByKey::<K, T>::new()));
            let kind = kind.downcast_mut::<ByKey<K, T>>().expect("entries are found by the type that they have");
            Arc::clone(kind.entry(key).or_default())
        };
        Arc::clone(cell.get_or_init(|| Arc::new(make())))
    }
}

impl fmt::Debug for Derived {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Derived")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn structures_are_made_once_for_each_type_and_key() {
        let derived = Derived::default();
        let first = derived.get(1usize, || vec![1]);
        assert!(Arc::ptr_eq(&first, &derived.get(1usize, || unreachable!("it is there"))));
        assert_eq!(*derived.get(2usize, || vec![2]), [2]);
        assert_eq!(*derived.get(1usize, || "another type"), "another type");
        assert_eq!(*derived.get("another key", || vec![3]), [3]);
    }

    #[test]
    fn one_structure_may_need_another() {
        let derived = Derived::default();
        assert_eq!(*derived.get(0usize, || *derived.get(1usize, || 5) + 1), 6);
    }
}
