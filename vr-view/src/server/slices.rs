//! Slices, and values at places: of the volume alone, whatever the picture does.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use axum::extract::{Query, State};
use axum::http::StatusCode;
use axum::http::header::CONTENT_TYPE;
use axum::response::{IntoResponse, Response};
use glam::DVec3;
use serde::Deserialize;
use vr_core::Control;

use super::Service;
use super::message::slice_bytes;
use super::truth::{json, refusal};
use crate::session::SliceQuery;

/// Sets a cancel flag when the request that it belongs to is given up: the page has asked for another slice meanwhile.
struct CancelOnDrop(Arc<AtomicBool>);

impl Drop for CancelOnDrop {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// Answers with a slice.
pub async fn slice(State(service): State<Service>, Query(query): Query<SliceQuery>) -> Response {
    let _turn = service.slices.acquire().await;
    let control = Control::default();
    let _given_up = CancelOnDrop(control.cancel_flag());
    let session = Arc::clone(&service.session);
    match tokio::task::spawn_blocking(move || session.slice(&query, &control)).await {
        Ok(Ok(slice)) => ([(CONTENT_TYPE, "application/octet-stream")], slice_bytes(&slice)).into_response(),
        Ok(Err(e)) => refusal(&e),
        Err(_) => (StatusCode::INTERNAL_SERVER_ERROR, "slicing has failed\n").into_response(),
    }
}

/// Place that is asked for, in world coordinates.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlaceQuery {
    x: f64,
    y: f64,
    z: f64,
}

/// Answers with value and label of a place.
pub async fn place(State(service): State<Service>, Query(PlaceQuery { x, y, z }): Query<PlaceQuery>) -> Response {
    let session = Arc::clone(&service.session);
    match tokio::task::spawn_blocking(move || session.place(DVec3::new(x, y, z))).await {
        Ok(Ok(place)) => json(place),
        Ok(Err(e)) => refusal(&e),
        Err(_) => (StatusCode::INTERNAL_SERVER_ERROR, "asking has failed\n").into_response(),
    }
}

/// Place in the picture, in heights of it to the right of and above its middle.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PickQuery {
    x: f64,
    y: f64,
}

/// Answers with what is seen at a place in the picture; `null` where nothing is.
pub async fn pick(State(service): State<Service>, Query(PickQuery { x, y }): Query<PickQuery>) -> Response {
    let session = Arc::clone(&service.session);
    match tokio::task::spawn_blocking(move || session.pick([x, y])).await {
        Ok(Ok(pick)) => json(pick),
        Ok(Err(e)) => refusal(&e),
        Err(_) => (StatusCode::INTERNAL_SERVER_ERROR, "asking has failed\n").into_response(),
    }
}
