// Samples of paths as VB 3.3 has them: positions in one one-dimensional texture, orientations in another.

fn path_sample(i: u32) -> PathSample {
    return PathSample(textureLoad(path_positions, i, 0).xyz, textureLoad(path_orientations, i, 0));
}
