//! Values as tables of TOML, and back.

use serde::Serialize;
use serde::de::{DeserializeOwned, Error};
use toml::Table;

use crate::scene::SceneFileError;

/// Returns the table that a value is written as, by way of its text: what serde makes of a type is compiled for texts alone, and not for
/// tables besides.
///
/// # Errors
/// [`SceneFileError::Text`] for a number that TOML cannot hold.
pub(crate) fn table_of(value: &impl Serialize) -> Result<Table, SceneFileError> {
    let failed = |e: &dyn std::fmt::Display| SceneFileError::Text { message: e.to_string() };
    toml::from_str(&toml::to_string(value).map_err(|e| failed(&e))?).map_err(|e| failed(&e))
}

/// Returns the value that a table stands for, by way of its text, as [`table_of`] does.
///
/// # Errors
/// The reader's error. Its place is one in a text that the user does not see.
pub(crate) fn value_of<T: DeserializeOwned>(table: &Table) -> Result<T, toml::de::Error> {
    toml::from_str(&toml::to_string(table).map_err(toml::de::Error::custom)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::FileRecord;

    #[test]
    fn a_value_goes_to_a_table_and_comes_back() {
        let file = FileRecord { name: "a \"b\".raw".to_owned(), sha256: "00".to_owned() };
        let table = table_of(&file).unwrap();
        assert_eq!(table.keys().collect::<Vec<_>>(), ["name", "sha256"]);
        assert_eq!(value_of::<FileRecord>(&table).unwrap(), file);
        assert!(value_of::<FileRecord>(&toml::from_str("name = 1").unwrap()).is_err());
    }
}
