//! Guard: what every request must bring, and what every answer says.

use std::net::{IpAddr, SocketAddr};

use axum::extract::{Request, State};
use axum::http::header::{
    CACHE_CONTROL, CONTENT_SECURITY_POLICY, HOST, HeaderName, ORIGIN, REFERRER_POLICY, X_CONTENT_TYPE_OPTIONS,
    X_FRAME_OPTIONS,
};
use axum::http::{HeaderMap, HeaderValue, Method, StatusCode};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

use super::Service;
use super::token::Token;

/// Reason why a request is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// The token is missing or wrong.
    Token,
    /// The page was reached by a name that is not this machine's: a name may be made to lead anywhere (DNS rebinding).
    Host,
    /// The request comes from another page.
    Origin,
}

impl IntoResponse for Refusal {
    fn into_response(self) -> Response {
        let (status, text) = match self {
            Self::Token => (StatusCode::NOT_FOUND, "not found: the address that vr view printed has a token in it\n"),
            Self::Host => {
                (StatusCode::FORBIDDEN, "refused: use the address that vr view printed, with numbers for the host\n")
            }
            Self::Origin => (StatusCode::FORBIDDEN, "refused: the request comes from another page\n"),
        };
        (status, text).into_response()
    }
}

/// Checks a request before anything else looks at it.
///
/// The first part of the path must be the token. `Host` must be an address in numbers, or `localhost`, with the port of the server. An `Origin`,
/// which browsers send with every socket and every request that changes something, must be the server itself; these must have one.
///
/// # Errors
/// The first thing that is wrong.
pub fn check(
    (method, path): (&Method, &str),
    headers: &HeaderMap,
    token: &Token,
    address: SocketAddr,
) -> Result<(), Refusal> {
    let first = path.strip_prefix('/').and_then(|rest| rest.split('/').next()).unwrap_or_default();
    if !token.is(first) {
        return Err(Refusal::Token);
    }
    let mut hosts = headers.get_all(HOST).iter();
    let host = hosts.next().and_then(|host| host.to_str().ok()).ok_or(Refusal::Host)?;
    if hosts.next().is_some() || !is_own_host(host, address) {
        return Err(Refusal::Host);
    }
    let mut origins = headers.get_all(ORIGIN).iter();
    let is_own_origin = |origin: &HeaderValue| origin.to_str().is_ok_and(|origin| origin == format!("http://{host}"));
    match origins.next() {
        None if headers.contains_key(axum::http::header::UPGRADE) || !method.is_safe() => Err(Refusal::Origin),
        Some(origin) if !is_own_origin(origin) || origins.next().is_some() => Err(Refusal::Origin),
        _ => Ok(()),
    }
}

/// True if a `Host` can only be this server: no name can be made to lead to an address in numbers. On loopback, loopback alone.
fn is_own_host(host: &str, address: SocketAddr) -> bool {
    if host == format!("localhost:{}", address.port()) {
        return address.ip().is_loopback();
    }
    host.parse::<SocketAddr>().is_ok_and(|host| {
        let is_fine = |ip: IpAddr| if address.ip().is_loopback() { ip.is_loopback() } else { true };
        host.port() == address.port() && is_fine(host.ip())
    })
}

/// Answers a request that passes [`check`], and adds to every answer what keeps other pages out.
pub async fn guard(State(service): State<Service>, request: Request, next: Next) -> Response {
    let checked = check((request.method(), request.uri().path()), request.headers(), &service.token, service.address);
    let host = request.headers().get(HOST).and_then(|host| host.to_str().ok()).unwrap_or_default().to_owned();
    let is_fine = checked.is_ok();
    let mut response = match checked {
        Ok(()) => next.run(request).await,
        Err(refusal) => refusal.into_response(),
    };
    // Older browsers do not count a socket as part of 'self'.
    let socket = if is_fine { format!(" ws://{host}") } else { String::new() };
    let policy = format!(
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; connect-src 'self'{socket}; \
         base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    );
    let headers = response.headers_mut();
    let fixed = [
        (X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (X_FRAME_OPTIONS, "DENY"),
        (REFERRER_POLICY, "no-referrer"),
        (CACHE_CONTROL, "no-store"),
        (HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
        (HeaderName::from_static("cross-origin-opener-policy"), "same-origin"),
        (HeaderName::from_static("permissions-policy"), "camera=(), microphone=(), geolocation=()"),
    ];
    for (name, value) in fixed {
        headers.insert(name, HeaderValue::from_static(value));
    }
    if let Ok(policy) = HeaderValue::from_str(&policy) {
        headers.insert(CONTENT_SECURITY_POLICY, policy);
    }
    response
}

#[cfg(test)]
mod tests {
    use super::*;
    use axum::http::header::UPGRADE;

    fn checked(path: &str, headers: &[(HeaderName, &str)], address: &str) -> Result<(), Refusal> {
        checked_as(&Method::GET, path, headers, address)
    }

    fn checked_as(method: &Method, path: &str, headers: &[(HeaderName, &str)], address: &str) -> Result<(), Refusal> {
        let token = Token::random().unwrap();
        let mut map = HeaderMap::new();
        for (name, value) in headers {
            map.append(name.clone(), HeaderValue::from_str(value).unwrap());
        }
        check((method, &path.replace("TOKEN", token.text())), &map, &token, address.parse().unwrap())
    }

    #[test]
    fn token_host_and_origin_are_checked() {
        let here = "127.0.0.1:8000";
        let host = |value| (HOST, value);
        assert_eq!(checked("/TOKEN/", &[host(here)], here), Ok(()));
        for path in ["/", "/x/", "//TOKEN/", "/TOKEN1/", "/x/TOKEN/", ""] {
            assert_eq!(checked(path, &[host(here)], here), Err(Refusal::Token), "{path}");
        }
        assert_eq!(checked("/TOKEN/", &[host("localhost:8000")], here), Ok(()));
        assert_eq!(checked("/TOKEN/", &[host("[::1]:8000")], here), Ok(()));
        for wrong in
            ["127.0.0.1:8001", "127.0.0.1", "evil.example:8000", "192.168.0.1:8000", "localhost", "127.0.0.1:8000@x"]
        {
            assert_eq!(checked("/TOKEN/", &[host(wrong)], here), Err(Refusal::Host), "{wrong}");
        }
        assert_eq!(checked("/TOKEN/", &[], here), Err(Refusal::Host));
        assert_eq!(checked("/TOKEN/", &[host(here), host(here)], here), Err(Refusal::Host));
        // On every interface: numbers alone.
        let open = "0.0.0.0:8000";
        assert_eq!(checked("/TOKEN/", &[host("192.168.0.1:8000")], open), Ok(()));
        for wrong in ["evil.example:8000", "localhost:8000", "192.168.0.1:80"] {
            assert_eq!(checked("/TOKEN/", &[host(wrong)], open), Err(Refusal::Host), "{wrong}");
        }
    }

    #[test]
    fn other_pages_are_kept_out() {
        let here = "127.0.0.1:8000";
        let with = |origins: &[&'static str], upgrade: bool| {
            let mut headers = vec![(HOST, here)];
            headers.extend(origins.iter().map(|&origin| (ORIGIN, origin)));
            headers.extend(upgrade.then_some((UPGRADE, "websocket")));
            checked("/TOKEN/socket", &headers, here)
        };
        assert_eq!(with(&["http://127.0.0.1:8000"], true), Ok(()));
        assert_eq!(with(&[], false), Ok(()));
        assert_eq!(with(&[], true), Err(Refusal::Origin));
        for wrong in
            ["null", "http://127.0.0.1:8001", "https://127.0.0.1:8000", "http://evil.example", "http://localhost:8000"]
        {
            assert_eq!(with(&[wrong], true), Err(Refusal::Origin), "{wrong}");
            assert_eq!(with(&[wrong], false), Err(Refusal::Origin), "{wrong}");
        }
        assert_eq!(with(&["http://127.0.0.1:8000", "http://evil.example"], true), Err(Refusal::Origin));
        // Requests that change something must say where they come from.
        for method in [Method::POST, Method::PUT, Method::DELETE] {
            let post = |origin: &[(HeaderName, &str)]| {
                checked_as(&method, "/TOKEN/open", &[&[(HOST, here)], origin].concat(), here)
            };
            assert_eq!(post(&[]), Err(Refusal::Origin));
            assert_eq!(post(&[(ORIGIN, "http://evil.example")]), Err(Refusal::Origin));
            assert_eq!(post(&[(ORIGIN, "http://127.0.0.1:8000")]), Ok(()));
        }
    }
}
