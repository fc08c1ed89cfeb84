//! What all formats refuse or leave out, and how text in STL begins.

/// The most face corners in a file: 2^26, some 22 million triangles.
pub const MAX_CORNERS: u64 = 1 << 26;

/// What is said of faces that are left out.
pub(super) fn lost_faces(count: u64) -> Option<String> {
    (count > 0).then(|| {
        format!(
            "faces of fewer than 3 corners, or with a position that is not finite, are skipped ({count} in the \
             file)"
        )
    })
}

pub(super) fn too_many_corners() -> String {
    format!("it has more than {MAX_CORNERS} face corners: split the model")
}

/// Whether a file begins as STL text does, perhaps after comments.
pub(super) fn begins_solid(content: &[u8]) -> bool {
    let lines = content.split(|&byte| byte == b'\n' || byte == b'\r').map(<[u8]>::trim_ascii_start);
    let mut lines = lines.take(1000).filter(|line| !line.is_empty() && !line.starts_with(b"#"));
    let word = lines.next().and_then(|line| line.get(..5));
    word.is_some_and(|word| word.eq_ignore_ascii_case(b"solid"))
}
