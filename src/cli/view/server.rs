//! The page over HTTP, for this machine alone.
//!
//! No request names a file: each path is one of those below, and what it tells is of the one picture. A
//! request whose host is not this server's comes from a page elsewhere whose name was made to mean this
//! machine; it is refused, as is one that a browser says another site has made.

use super::Page;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;
use tiny_http::{Header, Method, Request, Response, Server};

const HTML: &str = include_str!("page.html");

/// How long a pixel of a render under way is waited for.
const PATIENCE: Duration = Duration::from_secs(5);

/// Requests that are answered side by side.
const WORKERS: usize = 4;

/// What each answer comes with: nothing is fetched from elsewhere, shown elsewhere or kept.
const RULES: [(&str, &str); 5] = [
    (
        "Content-Security-Policy",
        "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; connect-src 'self'; \
         frame-ancestors 'none'; base-uri 'none'; form-action 'none'",
    ),
    ("X-Content-Type-Options", "nosniff"),
    ("Cross-Origin-Resource-Policy", "same-origin"),
    ("Referrer-Policy", "no-referrer"),
    ("Cache-Control", "no-store"),
];

/// Serves a page from threads of its own, which end with the program. Where it is.
pub fn serve(page: Arc<Page>, port: u16) -> std::io::Result<SocketAddr> {
    let server = Server::http(("127.0.0.1", port)).map_err(std::io::Error::other)?;
    let address = server.server_addr().to_ip().ok_or_else(|| std::io::Error::other("it has no address"))?;
    let server = Arc::new(server);
    for _ in 0..WORKERS {
        let (server, page) = (server.clone(), page.clone());
        std::thread::Builder::new().name("page".to_owned()).spawn(move || {
            while let Ok(request) = server.recv() {
                if request.body_length().is_some_and(|bytes| bytes > LARGEST_BODY) {
                    // To drop it takes memory for all that it says it sends.
                    std::mem::forget(request);
                    continue;
                }
                let answer = answer(&page, &request, address);
                // Who asked may have gone.
                let _ = request.respond(answer);
            }
        })?;
    }
    Ok(address)
}

/// Bytes of the largest request that is answered. The page sends none.
const LARGEST_BODY: usize = 1 << 16;

type Answer = Response<std::io::Cursor<Vec<u8>>>;

fn answer(page: &Page, request: &Request, address: SocketAddr) -> Answer {
    let header = |name: &'static str| {
        let found = request.headers().iter().find(|header| header.field.equiv(name));
        found.map(|header| header.value.as_str().to_owned())
    };
    let port = address.port();
    // Browsers leave out the port of their protocol.
    let host = header("Host").map(|host| if port == 80 && !host.contains(':') { host + ":80" } else { host });
    let hosts = [format!("127.0.0.1:{port}"), format!("localhost:{port}")];
    let is_own = host.is_some_and(|host| hosts.contains(&host));
    let is_foreign =
        header("Sec-Fetch-Site").is_some_and(|site| !["same-origin", "none"].contains(&site.as_str()));
    if !is_own || is_foreign {
        return refusal(403);
    }
    if *request.method() != Method::Get {
        return refusal(405);
    }
    let (path, query) = request.url().split_once('?').unwrap_or((request.url(), ""));
    match path {
        "/" => told("text/html; charset=utf-8", HTML.as_bytes().to_vec()),
        "/state" => json(&page.state()),
        "/channel" => {
            let name = decoded(query.strip_prefix("name=").unwrap_or(""));
            match name.map(|name| page.channel(&name)) {
                Some(Ok(Some(values))) => told("application/octet-stream", values),
                Some(Err(_)) => refusal(500),
                Some(Ok(None)) | None => refusal(404),
            }
        }
        "/pixel" => pixel(page, query).unwrap_or_else(|| refusal(404)),
        _ => refusal(404),
    }
}

/// The pixel that `x=X&y=Y` asks for.
fn pixel(page: &Page, query: &str) -> Option<Answer> {
    let (x, y) = query.split_once('&')?;
    let number = |text: &str, name: &str| text.strip_prefix(name)?.parse().ok();
    let Ok(answered) = page.pixel([number(x, "x=")?, number(y, "y=")?]) else { return Some(refusal(500)) };
    Some(answered?.recv_timeout(PATIENCE).map_or_else(|_| refusal(503), |value| json(&value)))
}

fn json(value: &serde_json::Value) -> Answer {
    told("application/json", value.to_string().into_bytes())
}

fn refusal(code: u16) -> Answer {
    told("text/plain", Vec::new()).with_status_code(code)
}

fn told(kind: &str, content: Vec<u8>) -> Answer {
    let headers = RULES.iter().copied().chain([("Content-Type", kind)]);
    let headers = headers.filter_map(|(name, value)| Header::from_bytes(name, value).ok());
    headers.fold(Response::from_data(content), Response::with_header)
}

/// Decodes the text of a URL, with some bytes as `%` and two digits. `None` where it is malformed.
fn decoded(text: &str) -> Option<String> {
    let mut bytes = Vec::new();
    let mut rest = text.as_bytes();
    while let [first, behind @ ..] = rest {
        rest = behind;
        if *first == b'%' {
            let digits = std::str::from_utf8(rest.get(..2)?).ok()?;
            bytes.push(u8::from_str_radix(digits, 16).ok()?);
            rest = &rest[2..];
        } else {
            bytes.push(*first);
        }
    }
    String::from_utf8(bytes).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_channels_come_back() {
        assert_eq!(decoded("S0.550%2C000000nm").as_deref(), Some("S0.550,000000nm"));
        assert_eq!(decoded("%C3%A9").as_deref(), Some("é"));
        for wrong in ["%", "%4", "%zz", "%ff"] {
            assert_eq!(decoded(wrong), None, "{wrong}");
        }
    }
}
