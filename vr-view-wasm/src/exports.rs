//! Functions that the page's worker calls, and those of its own that it lends. The only unsafe lines of the crate are here.
//!
//! Bytes come in by [`room`], which makes a buffer that the worker fills before it calls the function that takes them; they go out by `take`, which copies them
//! before it returns.
#![allow(unsafe_code)]

use std::cell::{Cell, RefCell};

use serde::{Deserialize, Serialize};
use vr_core::{clock, memory};
use vr_view::message::headed;

use crate::program::{Output, Program};

/// Milliseconds between two looks for messages that wait: each costs a part of one.
const GLANCE: f64 = 16.0;
/// Bytes that a module can address.
const ADDRESSABLE: u64 = 1 << 32;

/// Kinds of bytes that go out.
const TEXT: u32 = 0;
const PICTURE: u32 = 1;
const ANSWER: u32 = 2;
const PANIC: u32 = 3;

mod page {
    #[link(wasm_import_module = "page")]
    unsafe extern "C" {
        // SAFETY: the worker reads its own clock and its own flag, and touches no memory of the module.
        pub safe fn now() -> f64;
        pub safe fn interrupted() -> u32;
        /// Copies bytes.
        pub fn take(kind: u32, start: *const u8, length: usize);
    }
}

thread_local! {
    static PROGRAM: RefCell<Option<Program>> = const { RefCell::new(None) };
    static INPUT: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
    static LAST_GLANCE: Cell<f64> = const { Cell::new(0.0) };
}

fn give(kind: u32, bytes: &[u8]) {
    // SAFETY: the worker copies that many bytes from there, which `bytes` borrows until it returns.
    unsafe { page::take(kind, bytes.as_ptr(), bytes.len()) }
}

/// True if a message waits; asked of the page now and then alone.
fn interrupted() -> bool {
    let now = page::now();
    if now - LAST_GLANCE.get() < GLANCE {
        return false;
    }
    LAST_GLANCE.set(now);
    page::interrupted() != 0
}

/// Does something with the program, and gives what it says.
fn with_program<T: Default>(act: impl FnOnce(&mut Program) -> T) -> T {
    PROGRAM.with_borrow_mut(|program| {
        let Some(program) = program else { return T::default() };
        let done = act(program);
        for output in program.outputs() {
            match output {
                Output::Text(text) => give(TEXT, text.as_bytes()),
                Output::Bytes(bytes) => give(PICTURE, &bytes),
            }
        }
        done
    })
}

/// Begins; to be called once, before anything else.
// SAFETY: no other function has this name.
#[unsafe(no_mangle)]
pub extern "C" fn begin() {
    clock::set_clock(|| page::now());
    // Memory that was given back is used again, but is not counted: what is left is no less than this.
    memory::set_meter(|| ADDRESSABLE - (core::arch::wasm32::memory_size(0) as u64) * 65536);
    std::panic::set_hook(Box::new(|panic| give(PANIC, panic.to_string().as_bytes())));
    match Program::begin(interrupted) {
        Ok(program) => PROGRAM.set(Some(program)),
        Err(e) => give(PANIC, e.to_string().as_bytes()),
    }
    with_program(|_| ());
}

/// Makes a buffer for bytes to come in; returns where it begins.
// SAFETY: no other function has this name.
#[unsafe(no_mangle)]
pub extern "C" fn room(length: usize) -> *mut u8 {
    INPUT.with_borrow_mut(|input| {
        *input = vec![0; length];
        input.as_mut_ptr()
    })
}

/// Takes the bytes that came in as a message.
// SAFETY: no other function has this name.
#[unsafe(no_mangle)]
pub extern "C" fn receive() {
    let text = String::from_utf8(INPUT.take()).unwrap_or_default();
    with_program(|program| program.receive(&text));
}

/// Draws one stage, if one is due; returns the milliseconds to wait, or a negative number.
// SAFETY: no other function has this name.
#[unsafe(no_mangle)]
pub extern "C" fn step() -> f64 {
    with_program(Program::step)
}

#[derive(Deserialize)]
struct Asked {
    id: u64,
    method: String,
    address: String,
}

#[derive(Serialize)]
struct Answered {
    id: u64,
    status: u16,
    kind: &'static str,
}

/// Takes the bytes that came in as a question: a head in JSON of so many bytes, and a body.
// SAFETY: no other function has this name.
#[unsafe(no_mangle)]
pub extern "C" fn ask(head: usize) {
    let input = INPUT.take();
    let (head, body) = input.split_at(head.min(input.len()));
    let Ok(Asked { id, method, address }) = serde_json::from_slice(head) else { return };
    let answer = with_program(|program| Some(program.ask(&method, &address, body)));
    if let Some(answer) = answer {
        let head = Answered { id, status: answer.status, kind: answer.media_type };
        give(ANSWER, &headed(&head, &answer.bytes));
    }
}
