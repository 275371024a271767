//! Gradients at the vertices of a mesh.

use glam::DVec3;

use super::FACES;

/// Returns the gradient at each vertex: the mean of those of the cells around it, weighted by their volumes.
pub(super) fn vertex_gradients(vertices: &[DVec3], cells: &[[u32; 4]], values: &[f64]) -> Vec<DVec3> {
    let mut sums = vec![DVec3::ZERO; vertices.len()];
    let mut volumes = vec![0.0; vertices.len()];
    for cell in cells {
        let at = cell.map(|v| vertices[v as usize]);
        let volume = (at[1] - at[0]).cross(at[2] - at[0]).dot(at[3] - at[0]);
        // Gradient times volume: the height above each face falls from 1 to 0 towards it.
        let first = values[cell[0] as usize];
        let weighted: DVec3 = (1..4)
            .map(|i| {
                let [a, b, c] = FACES[i].map(|k| at[k]);
                (b - a).cross(c - a) * (first - values[cell[i] as usize])
            })
            .sum();
        for &v in cell {
            sums[v as usize] += weighted;
            volumes[v as usize] += volume;
        }
    }
    sums.iter().zip(&volumes).map(|(&sum, &volume)| if volume > 0.0 { sum / volume } else { DVec3::ZERO }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_linear_field_has_one_gradient() {
        let vertices = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z, DVec3::new(1.0, 2.0, 3.0)];
        let gradient = DVec3::new(0.5, -2.0, 3.0);
        let values: Vec<f64> = vertices.iter().map(|v| 7.0 + gradient.dot(*v)).collect();
        for found in vertex_gradients(&vertices, &[[0, 1, 2, 3], [1, 2, 3, 4]], &values) {
            assert!((found - gradient).length() < 1e-14, "{found}");
        }
    }
}
