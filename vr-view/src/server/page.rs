//! Files of the page over HTTP.

use axum::extract::Path;
use axum::http::StatusCode;
use axum::http::header::CONTENT_TYPE;
use axum::response::{IntoResponse, Response};

use crate::page::FILES;

/// Answers with the page itself.
pub async fn index() -> Response {
    file(Path((String::new(), "index.html".to_owned()))).await
}

/// Answers with a file of the page.
pub async fn file(Path((_, name)): Path<(String, String)>) -> Response {
    match FILES.iter().find(|(file, ..)| *file == name) {
        Some((_, kind, text)) => ([(CONTENT_TYPE, *kind)], *text).into_response(),
        None => (StatusCode::NOT_FOUND, "not found\n").into_response(),
    }
}
