//! Answers to a page that asks how far the picture at rest is from the truth.

use std::sync::Arc;

use axum::extract::{Query, State};
use axum::http::StatusCode;
use axum::http::header::CONTENT_TYPE;
use axum::response::{IntoResponse, Response};
use serde::{Deserialize, Serialize};
use vr_core::RenderError;

use super::Service;
use super::message::second_picture_bytes;
use crate::session::{Quality, Session, Setting, TruthError};

/// Answers with the error map.
pub async fn error_map(State(service): State<Service>) -> Response {
    answer(service, |session| session.error_map(), json).await
}

/// Pixel that is asked for.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PixelQuery {
    x: u32,
    y: u32,
    /// Renderer of the second picture, where the pixel is one of that.
    renderer: Option<String>,
    /// Its quality.
    quality: Option<Quality>,
}

/// Answers with the plot of a pixel's ray.
pub async fn ray(State(service): State<Service>, Query(query): Query<PixelQuery>) -> Response {
    let PixelQuery { x, y, renderer, quality } = query;
    let ask = move |session: &Session| match renderer {
        Some(renderer) => session.ray_of([x, y], &Setting { renderer, quality }),
        None => session.ray([x, y]),
    };
    answer(service, ask, json).await
}

/// Answers with the picture of a second setting.
pub async fn second(State(service): State<Service>, Query(setting): Query<Setting>) -> Response {
    let coding = service.coding();
    let bytes = move |picture| {
        ([(CONTENT_TYPE, "application/octet-stream")], second_picture_bytes(&picture, coding)).into_response()
    };
    answer(service, move |session| session.second(&setting), bytes).await
}

/// An answer in JSON.
pub fn json<T: Serialize>(found: T) -> Response {
    let text = serde_json::to_string(&found).expect("words and numbers have texts");
    ([(CONTENT_TYPE, "application/json")], text).into_response()
}

/// Answers one question at a time; with status 409 where the scene has changed meanwhile, so that the question is stale.
async fn answer<T: Send + 'static>(
    service: Service,
    question: impl FnOnce(&Session) -> Result<T, TruthError> + Send + 'static,
    encode: impl FnOnce(T) -> Response,
) -> Response {
    let _turn = service.exports.acquire().await;
    let session = Arc::clone(&service.session);
    match tokio::task::spawn_blocking(move || question(&session)).await {
        Ok(Ok(found)) => encode(found),
        Ok(Err(e)) => refusal(&e),
        Err(_) => (StatusCode::INTERNAL_SERVER_ERROR, "drawing has failed\n").into_response(),
    }
}

/// The answer in words to a question that has none.
pub fn refusal(error: &TruthError) -> Response {
    match error {
        TruthError::Render(RenderError::Cancelled) => (StatusCode::CONFLICT, "the scene has changed\n").into_response(),
        e => (StatusCode::UNPROCESSABLE_ENTITY, format!("{e}\n")).into_response(),
    }
}
