//! A tetrahedron in every format.

pub const CORNERS: [[f64; 3]; 4] = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 0.5, 0.0], [0.0, 0.0, -1.25]];
pub const FACES: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
const COLORS: [[u8; 3]; 4] = [[255, 0, 0], [0, 188, 0], [0, 0, 255], [9, 9, 9]];
const NORMALS: [[f32; 3]; 4] = [[-1.0, -1.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]];

fn words<T: ToString>(numbers: impl IntoIterator<Item = T>) -> String {
    numbers.into_iter().map(|n| n.to_string()).collect::<Vec<_>>().join(" ")
}

pub fn stl_text() -> String {
    let vertex = |v: u32| format!("      vertex {}\n", words(CORNERS[v as usize]));
    let facet = |f: &[u32; 3]| {
        let corners: String = f.iter().map(|&v| vertex(v)).collect();
        format!("  facet normal nan 0 0\n    outer loop\n{corners}    endloop\n  endfacet\n")
    };
    format!("solid a tetrahedron\n{}endsolid a tetrahedron\n", FACES.iter().map(facet).collect::<String>())
}

pub fn stl_binary(title: &[u8]) -> Vec<u8> {
    let mut bytes = title.to_vec();
    bytes.resize(80, b' ');
    bytes.extend((FACES.len() as u32).to_le_bytes());
    for face in FACES {
        bytes.extend([0; 12]);
        for x in face.iter().flat_map(|&v| CORNERS[v as usize]) {
            bytes.extend((x as f32).to_le_bytes());
        }
        bytes.extend([7, 7]);
    }
    bytes
}

pub fn obj() -> String {
    let vertices: String = CORNERS.iter().map(|&c| format!("v {}\n", words(c))).collect();
    let faces: String = FACES.iter().map(|f| format!("f {}\n", words(f.map(|v| v + 1)))).collect();
    vertices + &faces
}

fn ply_header(format: &str) -> String {
    let of = |of: &str, names: &str| names.split(' ').map(|n| format!("property {of} {n}\n")).collect::<String>();
    let vertex = of("double", "x y z") + &of("float", "nx ny nz") + &of("uchar", "red green blue");
    format!(
        "ply\nformat {format} 1.0\ncomment by hand\nelement vertex 4\n{vertex}element face 4\n\
         property list uchar int vertex_indices\nend_header\n"
    )
}

pub fn ply_text() -> String {
    let vertices: String =
        (0..4).map(|v| format!("{} {} {}\n", words(CORNERS[v]), words(NORMALS[v]), words(COLORS[v]))).collect();
    let faces: String = FACES.iter().map(|&f| format!("3 {}\n", words(f))).collect();
    ply_header("ascii") + &vertices + &faces
}

pub fn ply_binary(big: bool) -> Vec<u8> {
    let mut bytes = ply_header(if big { "binary_big_endian" } else { "binary_little_endian" }).into_bytes();
    let mut put = |number: &[u8]| {
        let mut number = number.to_vec();
        if big {
            number.reverse();
        }
        bytes.extend(number);
    };
    for v in 0..4 {
        CORNERS[v].iter().for_each(|x| put(&x.to_le_bytes()));
        NORMALS[v].iter().for_each(|x| put(&x.to_le_bytes()));
        COLORS[v].iter().for_each(|x| put(&x.to_le_bytes()));
    }
    for face in FACES {
        put(&[3]);
        face.iter().for_each(|v| put(&(*v as i32).to_le_bytes()));
    }
    bytes
}
