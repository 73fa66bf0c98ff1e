//! Parts that open on a click. What a reader may never look at weighs little: a large part travels compressed, and the script
//! of the page unpacks it when it is opened.

use std::io::Write;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use maud::{Markup, PreEscaped, html};

/// Smaller parts stand in the page as they are.
const LARGE: usize = 16_000;

/// A part under its summary.
pub(super) fn fold(class: &str, summary: &str, body: Markup) -> Markup {
    html! {
        details.(class) {
            summary { (summary) }
            @match pack(&body.0) {
                Some(packed) => script.packed type="text/plain" { (PreEscaped(packed)) },
                None => (body),
            }
        }
    }
}

/// The text as zlib's format in base 64, where it is large.
fn pack(text: &str) -> Option<String> {
    if text.len() < LARGE {
        return None;
    }
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    // Writing into memory does not fail; if it did, the part would stand in the page as it is.
    encoder.write_all(text.as_bytes()).ok()?;
    Some(BASE64_STANDARD.encode(encoder.finish().ok()?))
}

#[cfg(test)]
mod tests {
    use std::io::Read;

    use super::*;

    #[test]
    fn what_is_packed_comes_out_as_it_was() {
        let text = "<p>Fehlerschranke ε ≤ 10⁻¹²</p>".repeat(1000);
        let packed = pack(&text).expect("it is large");
        assert!(
            packed.len() < text.len() / 10 && packed.chars().all(|c| c.is_ascii_alphanumeric() || "+/=".contains(c))
        );
        let bytes = BASE64_STANDARD.decode(packed).expect("base 64");
        let mut unpacked = String::new();
        flate2::read::ZlibDecoder::new(bytes.as_slice()).read_to_string(&mut unpacked).expect("zlib");
        assert_eq!(unpacked, text);
        assert_eq!(pack("short"), None);
    }
}
