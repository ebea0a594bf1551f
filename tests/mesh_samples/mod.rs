//! One small sheet in every mesh format.

use dorsum::geom::Vec3;
use dorsum::surface::RawMesh;

/// A small sheet, 300 mm wide.
pub fn sheet() -> RawMesh {
    let mut mesh = RawMesh::default();
    for j in 0..4 {
        for i in 0..4 {
            let (x, y) = (f64::from(i) * 70.1, f64::from(j) * 71.3);
            mesh.positions.push(Vec3::new(x, y, (x * y) / 700.0));
        }
    }
    for j in 0..3 {
        for i in 0..3 {
            let a = j * 4 + i;
            mesh.triangles
                .extend([[a, a + 1, a + 5], [a, a + 5, a + 4]]);
        }
    }
    mesh
}

fn as_f32(mesh: &RawMesh) -> Vec<[f32; 3]> {
    mesh.positions
        .iter()
        .map(|p| p.as_vec3().to_array())
        .collect()
}

pub fn obj_text(mesh: &RawMesh) -> String {
    let mut text = String::from("# a sheet\nmtllib none.mtl\no sheet\n");
    for [x, y, z] in mesh.positions.iter().map(|p| p.to_array()) {
        text += &format!("v {x} {y} {z}\n");
    }
    text += "vt 0 0\nvn 0 0 1\nusemtl skin\ns off\n";
    for (i, t) in mesh.triangles.iter().enumerate() {
        let [a, b, c] = t.map(|v| v + 1);
        text += &match i % 3 {
            0 => format!("f {a} {b} {c}\n"),
            1 => format!("f {a}/1/1 {b}/1/1 {c}/1/1\ng part{i}\n"),
            _ => format!("f {a}//1 {b}//1 {c}//1\n"),
        };
    }
    text
}

pub fn stl_text(mesh: &RawMesh) -> String {
    let mut text = String::from("solid sheet\n");
    let places = as_f32(mesh);
    for t in &mesh.triangles {
        text += " facet normal 0 0 1\n  outer loop\n";
        for &v in t {
            let [x, y, z] = places[v as usize];
            text += &format!("   vertex {x} {y} {z}\n");
        }
        text += "  endloop\n endfacet\n";
    }
    text + "endsolid sheet\n"
}

pub fn stl_binary(mesh: &RawMesh) -> Vec<u8> {
    let mut bytes = b"solid by a program that has not read the format".to_vec();
    bytes.resize(80, b' ');
    bytes.extend((mesh.triangles.len() as u32).to_le_bytes());
    let places = as_f32(mesh);
    for t in &mesh.triangles {
        bytes.extend([0; 12]);
        bytes.extend(
            (t.iter())
                .flat_map(|&v| places[v as usize])
                .flat_map(f32::to_le_bytes),
        );
        bytes.extend([0; 2]);
    }
    bytes
}

/// With colours, a list besides the corners and quadrilaterals.
pub fn ply_binary(mesh: &RawMesh, little: bool) -> Vec<u8> {
    let order = if little { "little" } else { "big" };
    let mut bytes = format!(
        "ply\r\nformat binary_{order}_endian 1.0\r\ncomment made in Sch\u{f6}nau\r\nelement camera 1\r\nproperty int id\r\n\
         element vertex {}\r\nproperty double x\r\nproperty double y\r\nproperty uchar red\r\nproperty double z\r\n\
         element face {}\r\nproperty list uchar float uv\r\nproperty list ushort int vertex_index\r\nend_header\r\n",
        mesh.positions.len(),
        mesh.triangles.len() / 2,
    )
    .into_bytes();
    let mut put = |value: &[u8]| {
        let mut value = value.to_vec();
        if !little {
            value.reverse();
        }
        bytes.extend(value);
    };
    put(&7_i32.to_le_bytes());
    for p in &mesh.positions {
        put(&p.x.to_le_bytes());
        put(&p.y.to_le_bytes());
        put(&[200]);
        put(&p.z.to_le_bytes());
    }
    for pair in mesh.triangles.chunks_exact(2) {
        put(&[1]);
        put(&0.5_f32.to_le_bytes());
        put(&4_u16.to_le_bytes());
        for v in [pair[0][0], pair[0][1], pair[0][2], pair[1][2]] {
            put(&(v as i32).to_le_bytes());
        }
    }
    bytes
}
