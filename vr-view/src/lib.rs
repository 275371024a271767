//! A window into a volume: a session that takes edits and gives pictures with their errors, a server, and a page.
//!
//! [`session`] knows scenes and renderers, and no network; [`server`] puts one session before browsers; the page is embedded in it.

pub mod server;
pub mod session;
