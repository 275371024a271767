//! The whole suite, stamped over a renderer.

/// Stamps every check over a renderer, ours or a stranger's, as tests of a module: hard cases within its documented errors, invariants,
/// updates, and orders of convergence.
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
                let renderer = $renderer;
                let errors = $crate::vr_core::Documented::hard_case_errors(&renderer);
                let bound = |case: &$crate::cases::Case| {
                    errors.for_case(case.name).unwrap_or_else(|| panic!("{}: no error is documented", case.name))
                };
                let table = $crate::check::survives_hard_cases(&renderer, bound, &$crate::Reference::new(1e-7));
                println!("{}", table.unwrap_or_else(|e| panic!("{e}")));
            }

            #[test]
            fn obeys_invariants() {
                let reports =
                    $crate::check::obeys_invariants(&$renderer, $tolerance, &$crate::check::Effort::cases($cases));
                for report in reports.unwrap_or_else(|e| panic!("{e}")) {
                    println!("{report}");
                }
            }

            #[test]
            fn converges_at_its_documented_orders() {
                let renderer = $renderer;
                for claim in $crate::vr_core::Documented::convergence(&renderer) {
                    let refinement = $crate::check::Refinement {
                        options: claim.options,
                        floor: claim.floor,
                        ..$crate::check::Refinement::new(claim.key, claim.orders.smooth)
                    };
                    let found = $crate::check::converges(&renderer, &refinement, &$crate::check::Effort::cases($cases));
                    println!("{}: {}", claim.name, found.unwrap_or_else(|e| panic!("{}: {e}", claim.name)));
                }
            }
        }
    };
}
