//! The baseline for tessellation: the same triangles, computed in advance.
#![allow(dead_code, unreachable_pub, reason = "every bench is a crate that uses a part of it")]

use std::collections::HashMap;

use freeform_surface::inspect::{DrawnVertex, StaticMesh, StaticVertex};
use freeform_surface::{Gl, Mesh, Patch, Scene};
use glam::{DMat4, DVec3};

/// The triangles of a scene's one surface at its level, in world space, with normals from `normal`.
pub fn of_surface(gl: &Gl, scene: &Scene, normal: fn(&Patch<'_>, f64, f64) -> DVec3) -> StaticMesh {
    let surface = &scene.surfaces[0];
    let level = scene.settings.tessellation.level().get() as usize;
    let mut vertices: Vec<StaticVertex> = Vec::new();
    let mut indices: Vec<u32> = Vec::new();
    for (number, patch) in (0..).zip(surface.patches()) {
        let first = vertices.len() as u32;
        for i in 0..(level + 1) * (level + 1) {
            let u = (i % (level + 1)) as f64 / level as f64;
            let v = (i / (level + 1)) as f64 / level as f64;
            let position = surface.transform.transform_point3(patch.at(u, v).position);
            let normal = surface.transform.transform_vector3(normal(&patch, u, v));
            vertices.push(StaticVertex {
                position: position.as_vec3().into(),
                u: u as f32,
                normal: normal.as_vec3().into(),
                v: v as f32,
                patch: number,
            });
        }
        for cell in 0..level * level {
            let corner = first + (cell / level * (level + 1) + cell % level) as u32;
            let above = corner + level as u32 + 1;
            indices.extend([corner, corner + 1, above, corner + 1, above + 1, above]);
        }
    }
    StaticMesh::new(gl, &vertices, &indices).expect("it fits")
}

/// The triangles of a mesh, one vertex for each pair of position and normal.
pub fn of_mesh(gl: &Gl, mesh: &Mesh) -> StaticMesh {
    let mut numbers = HashMap::new();
    let (mut vertices, mut indices) = (Vec::new(), Vec::new());
    for corner in mesh.triangles().iter().flatten() {
        indices.push(*numbers.entry((corner.position, corner.normal)).or_insert_with(|| {
            vertices.push(StaticVertex {
                position: mesh.positions()[corner.position as usize].as_vec3().into(),
                u: 0.0,
                normal: mesh.normals()[corner.normal as usize].as_vec3().into(),
                v: 0.0,
                patch: 0,
            });
            vertices.len() as u32 - 1
        }));
    }
    StaticMesh::new(gl, &vertices, &indices).expect("it fits")
}

/// Captured triangles, one vertex for each different corner of a patch. `to_world` is the matrix from view space.
pub fn of_drawn(gl: &Gl, drawn: &[DrawnVertex], to_world: &DMat4) -> StaticMesh {
    let mut numbers = HashMap::new();
    let (mut vertices, mut indices) = (Vec::new(), Vec::new());
    for corner in drawn {
        let key = (corner.patch, corner.uv.map(f32::to_bits));
        indices.push(*numbers.entry(key).or_insert_with(|| {
            let [x, y, z, _] = corner.position.map(f64::from);
            let normal = DVec3::from(corner.normal.map(f64::from));
            vertices.push(StaticVertex {
                position: to_world.transform_point3(DVec3::new(x, y, z)).as_vec3().into(),
                u: corner.uv[0],
                normal: to_world.transform_vector3(normal).as_vec3().into(),
                v: corner.uv[1],
                patch: corner.patch,
            });
            vertices.len() as u32 - 1
        }));
    }
    StaticMesh::new(gl, &vertices, &indices).expect("it fits")
}
