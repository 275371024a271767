//! Results for people and for other tools: a page, tables, plots.

mod cases_section;
mod chart;
mod figure;
mod headline;
mod marker;
mod order_section;
mod page;
mod plots;
mod point_table;
mod subject_section;
mod summary;
mod table;
mod terms;

pub use headline::{headline_plot, headline_table, reaching};
pub use page::{is_page, page};
pub use table::csv;
