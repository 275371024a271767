//! The whole suite, stamped over a renderer.

/// Stamps every check over a renderer, ours or a stranger's, as tests of a module: hard cases within its documented errors, invariants,
/// updates, orders of convergence, and settings that can be configured.
///
/// `invariants` is the rounding that invariants are allowed, `cases` the number of random scenes of each check.
///
/// ```
/// use vr_physics::renderer_suite;
/// use vr_physics::check::faulty_marcher::Marcher;
///
/// renderer_suite!(marcher: Marcher::default(), invariants = 1e-4, cases = 8);
/// # fn main() {}
/// ```
#[macro_export]
macro_rules! renderer_suite {
    ($module:ident: $renderer:expr, invariants = $tolerance:expr, cases = $cases:expr) => {
        #[cfg(test)]
        mod $module {
            #[allow(unused_imports)]
            use super::*;

            #[test]
            fn survives_hard_cases() {
                let table = $crate::check::survives_documented_cases(&$renderer, &$crate::Reference::new(1e-7));
                println!("{}", table.unwrap_or_else(|e| panic!("{e}")));
            }

            #[test]
            fn obeys_invariants() {
                let effort = $crate::check::Effort::cases($cases);
                let reports = $crate::check::obeys_invariants(&$renderer, $tolerance, &effort);
                for report in reports.unwrap_or_else(|e| panic!("{e}")) {
                    println!("{report}");
                }
            }

            #[test]
            fn converges_at_its_documented_orders() {
                let effort = $crate::check::Effort::cases($cases);
                let found = $crate::check::converges_as_documented(&$renderer, &effort);
                for (claim, convergence) in found.unwrap_or_else(|e| panic!("{e}")) {
                    println!("{claim}: {convergence}");
                }
            }

            #[test]
            fn documents_what_can_be_set() {
                $crate::check::documents_what_can_be_set(&$renderer, 4).unwrap_or_else(|e| panic!("{e}"));
            }
        }
    };
}
