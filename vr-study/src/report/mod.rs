//! Results for people and for other tools: a page, tables, plots.

mod chart;
mod headline;
mod page;
mod plots;
mod table;

pub use headline::{headline_plot, headline_table};
pub use page::page;
pub use table::csv;
