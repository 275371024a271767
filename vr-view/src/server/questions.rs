//! Answers to a page's questions over HTTP.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use axum::extract::State;
use axum::http::header::{CONTENT_DISPOSITION, CONTENT_TYPE};
use axum::http::{StatusCode, Uri};
use axum::response::{IntoResponse, Response};
use vr_core::Control;

use super::Service;
use crate::question::{Answer, Question, Turn};

/// Sets a cancel flag when the request that it belongs to is given up: the page has asked something else meanwhile.
struct CancelOnDrop(Arc<AtomicBool>);

impl Drop for CancelOnDrop {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

impl IntoResponse for Answer {
    fn into_response(self) -> Response {
        let status = StatusCode::from_u16(self.status).unwrap_or(StatusCode::INTERNAL_SERVER_ERROR);
        let mut response = (status, [(CONTENT_TYPE, self.media_type)], self.bytes).into_response();
        let disposition = self.file_name.map(|name| format!("attachment; filename=\"{name}\""));
        if let Some(disposition) = disposition.and_then(|text| text.parse().ok()) {
            response.headers_mut().insert(CONTENT_DISPOSITION, disposition);
        }
        response
    }
}

/// Answers the question of an address behind the token.
pub async fn answer(State(service): State<Service>, address: Uri) -> Response {
    let path = address.path().splitn(3, '/').nth(2).unwrap_or_default();
    let question = match Question::parse(path, address.query().unwrap_or_default()) {
        Ok(question) => question,
        Err(answer) => return answer.into_response(),
    };
    let turns = match question.turn() {
        Turn::Picture => Some(&service.exports),
        Turn::Slice => Some(&service.slices),
        Turn::None => None,
    };
    let _turn = match turns {
        Some(turns) => turns.acquire().await.ok(),
        None => None,
    };
    let control = Control::default();
    let _given_up = CancelOnDrop(control.cancel_flag());
    let (session, coding) = (Arc::clone(&service.session), service.coding());
    match tokio::task::spawn_blocking(move || question.answer(&session, coding, &control)).await {
        Ok(answer) => answer.into_response(),
        Err(_) => (StatusCode::INTERNAL_SERVER_ERROR, "answering has failed\n").into_response(),
    }
}
