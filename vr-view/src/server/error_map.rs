//! Answer to a page that asks how far the picture at rest is from the truth.

use std::sync::Arc;

use axum::extract::State;
use axum::http::StatusCode;
use axum::http::header::CONTENT_TYPE;
use axum::response::{IntoResponse, Response};
use vr_core::RenderError;

use super::Service;
use crate::session::ErrorMapError;

/// Answers with the error map in JSON; with status 409 where the scene has changed meanwhile, so that the question is stale.
pub async fn answer(State(service): State<Service>) -> Response {
    let _turn = service.exports.acquire().await;
    let session = Arc::clone(&service.session);
    match tokio::task::spawn_blocking(move || session.error_map()).await {
        Ok(Ok(map)) => {
            let text = serde_json::to_string(&map).expect("words and numbers have texts");
            ([(CONTENT_TYPE, "application/json")], text).into_response()
        }
        Ok(Err(ErrorMapError::Render(RenderError::Cancelled))) => {
            (StatusCode::CONFLICT, "the scene has changed\n").into_response()
        }
        Ok(Err(e)) => (StatusCode::UNPROCESSABLE_ENTITY, format!("{e}\n")).into_response(),
        Err(_) => (StatusCode::INTERNAL_SERVER_ERROR, "drawing has failed\n").into_response(),
    }
}
