// corner: a corner of a triangle on its way to the picture, for draws whose pixels read the atlas.
// The includer has `params` with `clip_from_world`.

#ifndef MYXO_CORNER
#define MYXO_CORNER

layout(set = 0, binding = 0) uniform usamplerBuffer corners;
layout(set = 0, binding = 1) uniform usamplerBuffer vertices;
layout(set = 0, binding = 2) readonly buffer Normals { uint normals[]; };
layout(set = 0, binding = 3) uniform usamplerBuffer strips;
layout(set = 0, binding = 4) uniform samplerBuffer poses;
layout(set = 0, binding = 9) readonly buffer Openness { uint openness[]; };

#include "placed.glsl"
#include "strip_table.glsl"

layout(location = 0) out vec3 position;
layout(location = 1) out vec3 normal;
layout(location = 2) centroid out vec2 uv;
layout(location = 3) flat out vec2 atlas_origin;
layout(location = 4) flat out vec4 atlas_axes;
layout(location = 5) flat out uint triangle;
layout(location = 6) out float open_share;

void place_corner(uint corner) {
    triangle = corner / 3u;
    uint k = corner - 3u * triangle;
    Vertex vertex = vertex_of(corner);
    Pose pose = pose_of(vertex.object);
    AtlasMap map = atlas_map_of(triangle);

    position = place_in_world(pose, vertex.position);
    normal = turn_to_world(pose, unpack_normal(normals[corner]));
    uv = vec2(k == 1u, k == 2u);
    atlas_origin = map.origin;
    atlas_axes = vec4(map.du, map.dv);
    // Four corners to a word.
    open_share = unpackUnorm4x8(openness[corner >> 2u])[corner & 3u];
    gl_Position = params.clip_from_world * vec4(position, 1.0);
}

#endif
