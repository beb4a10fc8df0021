// surface: draws every object's triangles, lit, with the trail on them.
// Reads   corners, vertices, normals, atlas_maps, poses, charts; its other stage trail, colors, brightest.
// Writes  the corner's place, normal and uv, and the triangle's map to the atlas and its chart's colour.
// Three invocations per triangle; nothing is indexed, because a vertex has another normal and uv in each triangle.
// Overflow: cannot happen; the draw has three vertices for each triangle.
#version 460
#include "types.glsl"
#include "shading.glsl"
#include "surface.glsl"

layout(set = 0, binding = 0) readonly buffer Corners { uint corners[]; };
layout(set = 0, binding = 1) readonly buffer Vertices { Vertex vertices[]; };
layout(set = 0, binding = 2) readonly buffer Normals { uint normals[]; };
layout(set = 0, binding = 3) readonly buffer AtlasMaps { AtlasMap atlas_maps[]; };
layout(set = 0, binding = 4) readonly buffer Poses { Pose poses[]; };
layout(set = 0, binding = 8) readonly buffer Charts { uint charts[]; };

layout(location = 0) out vec3 position;
layout(location = 1) out vec3 normal;
layout(location = 2) centroid out vec2 uv;
layout(location = 3) flat out vec2 atlas_origin;
layout(location = 4) flat out vec4 atlas_axes;
layout(location = 5) flat out uint chart;

void main() {
    uint corner = uint(gl_VertexIndex);
    uint triangle = corner / 3u;
    uint k = corner - 3u * triangle;
    Vertex vertex = vertices[corners[corner]];
    Pose pose = poses[vertex.object];
    AtlasMap map = atlas_maps[triangle];

    position = place_in_world(pose, vertex.position);
    normal = turn_to_world(pose, unpack_normal(normals[corner]));
    uv = vec2(k == 1u, k == 2u);
    atlas_origin = map.origin;
    atlas_axes = vec4(map.du, map.dv);
    chart = charts[triangle];
    gl_Position = params.clip_from_world * vec4(position, 1.0);
}
