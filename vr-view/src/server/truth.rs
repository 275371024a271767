//! Answers to a page that asks how far the picture at rest is from the truth.

use std::sync::Arc;

use axum::extract::{Query, State};
use axum::http::StatusCode;
use axum::http::header::CONTENT_TYPE;
use axum::response::{IntoResponse, Response};
use serde::{Deserialize, Serialize};
use vr_core::RenderError;

use super::Service;
use crate::session::{Session, TruthError};

/// Answers with the error map.
pub async fn error_map(State(service): State<Service>) -> Response {
    answer(service, |session| session.error_map()).await
}

/// Pixel that is asked for.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PixelQuery {
    x: u32,
    y: u32,
}

/// Answers with the plot of a pixel's ray.
pub async fn ray(State(service): State<Service>, Query(PixelQuery { x, y }): Query<PixelQuery>) -> Response {
    answer(service, move |session| session.ray([x, y])).await
}

/// Answers in JSON, one question at a time; with status 409 where the scene has changed meanwhile, so that the question is stale.
async fn answer<T: Serialize + Send + 'static>(
    service: Service,
    question: impl FnOnce(&Session) -> Result<T, TruthError> + Send + 'static,
) -> Response {
    let _turn = service.exports.acquire().await;
    let session = Arc::clone(&service.session);
    match tokio::task::spawn_blocking(move || question(&session)).await {
        Ok(Ok(found)) => {
            let text = serde_json::to_string(&found).expect("words and numbers have texts");
            ([(CONTENT_TYPE, "application/json")], text).into_response()
        }
        Ok(Err(TruthError::Render(RenderError::Cancelled))) => {
            (StatusCode::CONFLICT, "the scene has changed\n").into_response()
        }
        Ok(Err(e)) => (StatusCode::UNPROCESSABLE_ENTITY, format!("{e}\n")).into_response(),
        Err(_) => (StatusCode::INTERNAL_SERVER_ERROR, "drawing has failed\n").into_response(),
    }
}
