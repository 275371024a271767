//! `vr view`.

use std::net::SocketAddr;

use clap::Args;
use vr_view::server::Server;

use super::{RendererArgs, SceneArgs};

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
#[derive(Clone, Copy, Debug, Args)]
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
}
