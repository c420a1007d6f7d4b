//! The mark by which movies of this program are recognised, in the form that each format has for comments.

/// The text of the mark.
pub(super) const MOVIE_MARK: &str = "rayframe movie";

/// A comment of a GIF file (GIF89a, 24), and the byte that ends the file.
pub(super) fn gif_comment_and_trailer() -> Vec<u8> {
    let mut bytes = vec![0x21, 0xfe, MOVIE_MARK.len() as u8];
    bytes.extend_from_slice(MOVIE_MARK.as_bytes());
    bytes.extend_from_slice(&[0, 0x3b]);
    bytes
}

/// The chunk of XMP metadata of a WebP file (RFC 9649, 2.7.1.5).
pub(super) fn webp_xmp_chunk() -> Vec<u8> {
    let xmp = format!(
        "<x:xmpmeta xmlns:x=\"adobe:ns:meta/\"><rdf:RDF xmlns:rdf=\"http://www.w3.org/1999/02/22-rdf-syntax-ns#\">\
         <rdf:Description rdf:about=\"\" xmlns:xmp=\"http://ns.adobe.com/xap/1.0/\" xmp:CreatorTool=\"{MOVIE_MARK}\"/>\
         </rdf:RDF></x:xmpmeta>"
    );
    let mut chunk = b"XMP ".to_vec();
    chunk.extend_from_slice(&(xmp.len() as u32).to_le_bytes());
    chunk.extend_from_slice(xmp.as_bytes());
    // Chunks have even lengths.
    if xmp.len() % 2 == 1 {
        chunk.push(0);
    }
    chunk
}
