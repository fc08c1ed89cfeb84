//! How much is read for one model, so that no file can ask for a machine's whole memory.

/// The most bytes in an OBJ file: 1 GiB.
pub const MAX_OBJ_BYTES: u64 = 1 << 30;

/// The most face corners in an OBJ file: 2^26, some 22 million triangles. There may be no more positions, texture
/// coordinates or normals either.
///
/// Reading takes up to about 150 bytes a corner at the worst moment (where no two corners are alike, and all
/// have colours), so this bounds memory near 10 GiB.
pub const MAX_CORNERS: u64 = 1 << 26;

/// The most bytes in the MTL files of a model together: 64 MiB.
pub const MAX_MTL_BYTES: u64 = 64 << 20;

/// The most materials that a model's MTL files may define, and that its faces may name.
pub const MAX_MATERIALS: usize = 65_536;

/// The most MTL files that are opened for one model. Materials that further ones define count as
/// unknown.
pub const MAX_LIBRARIES: usize = 1024;

/// The most texture files that are tried for one model. Together they may have as many texels as one
/// file by itself: [`MAX_FILE_TEXELS`](crate::texture::MAX_FILE_TEXELS).
pub const MAX_TEXTURES: usize = 1024;

/// The most warnings that are listed. [`Warning::More`](crate::obj::Warning::More) counts the rest.
pub const MAX_WARNINGS: usize = 100;
