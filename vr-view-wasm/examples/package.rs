//! Writes the page without a server into one file: `cargo run --release -p vr-view-wasm --example package -- MODULE PAGE`.
//!
//! The module is what `cargo build --release --target wasm32-unknown-unknown -p vr-view-wasm` makes; `vr-view-wasm/page.sh` does both.

use std::error::Error;
use std::fs;

use vr_view_wasm::package::package;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [module, page] = &arguments[..] else { return Err("usage: package MODULE PAGE".into()) };
    let bytes = fs::read(module).map_err(|e| format!("{module}: {e}"))?;
    let text = package(&bytes).map_err(|e| format!("{module}: {e}"))?;
    fs::write(page, &text).map_err(|e| format!("{page}: {e}"))?;
    println!("{page}: {:.1} MB, of a module of {:.1} MB", text.len() as f64 / 1e6, bytes.len() as f64 / 1e6);
    Ok(())
}
