//! `vr view`.

use std::net::SocketAddr;
use std::path::PathBuf;

use clap::Args;
use vr_view::server::Server;

use super::{RendererArgs, SceneArgs};
use crate::memory_limit;

/// `vr view`.
#[derive(Debug, Args)]
pub struct ViewArgs {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// The renderer and its options.
    #[command(flatten)]
    pub renderer: RendererArgs,
    /// The page.
    #[command(flatten)]
    pub page: PageArgs,
}

/// The page.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Page")]
pub struct PageArgs {
    /// Print the address, and open no browser
    #[arg(long)]
    pub no_open: bool,
    /// Go on when the last page is closed, until Ctrl-C
    #[arg(long)]
    pub stay: bool,
    /// Listen at this address; another than the default is reached from other machines, without encryption
    #[arg(long, value_name = "ADDRESS:PORT", default_value_t = Server::USUAL)]
    pub listen: SocketAddr,
    /// Let the page open files below this folder by their paths
    #[arg(long, value_name = "FOLDER")]
    pub folder: Option<PathBuf>,
    /// Size of the files that the page may send, together
    #[arg(long, value_name = "SIZE", value_parser = memory_limit::size, default_value = "1GiB")]
    pub max_upload: u64,
}
