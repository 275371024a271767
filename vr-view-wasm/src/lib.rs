//! The page of [`vr_view`] without a server: session and renderers as a WebAssembly module, which a worker of the page holds.
//!
//! [`Program`] takes the messages and questions that a server would, and gives the same answers, made by the same code. It has no thread: the
//! page's worker calls [`Program::step`] between messages. The functions that the worker calls are in a module of their own, compiled for the browser alone.
//!
//! # Example
//! The program is driven as the page's worker drives it, and begins with a phantom:
//! ```
//! use vr_view_wasm::{Output, Program};
//!
//! let mut program = Program::begin(|| false)?;
//! program.receive(r#"{"number": 1, "edit": {"kind": "size", "size": [48, 32]}}"#);
//! // A negative wait: nothing is left to do.
//! while program.step() >= 0.0 {}
//! let pictures = program.outputs().into_iter().filter(|output| matches!(output, Output::Bytes(_))).count();
//! assert!(pictures >= 3, "a draft, a sharp one, and one that is proven");
//! # Ok::<(), vr_view_wasm::BeginError>(())
//! ```

#[cfg(all(target_family = "wasm", target_os = "unknown"))]
mod exports;
mod files;
#[cfg(not(target_family = "wasm"))]
pub mod package;
mod program;
mod renderers;
mod subject;

pub use program::{Output, Program};
pub use renderers::renderers;
pub use subject::BeginError;
