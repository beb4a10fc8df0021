// types: the structs that kernels share with the host (src/sim/types.rs and src/mesh/surface.rs).
// Same fields, same order; the build compares sizes and offsets. std430: a vec3 is always followed by a scalar.

#ifndef MYXO_TYPES
#define MYXO_TYPES

const uint NONE = 0xffffffffu;

struct Particle { uint triangle; float u; float v; uint id; };
struct Motion { float heading_p; float heading_h; float pending; uint flags; };
struct Population { uint living; uint births; uint deaths; uint refused; uint born; uint died; };
struct Meal { uint remaining; uint eaten; uint amount; uint level; float strength; float scent; float projection; uint pad0; };
struct Mark { vec3 position; uint object; vec3 normal; float radius; uint is_food; uint pad0; uint pad1; uint pad2; };
struct Triangle { float ab; float cp; float ch; uint object; };
struct HalfEdge { uint twin; float cos; float sin; uint fine; };
struct AtlasMap { vec2 origin; vec2 du; vec2 dv; };
struct Vertex { vec3 position; uint object; };
struct Pose { vec4 x; vec4 y; vec4 z; };
struct Window { uint start; uint count; };
struct Border { uint left; uint came; uint front; uint gained; uint first; uint list; uint holes; uint strays; };
struct Transfer {
    vec3 position; uint particle;
    vec3 heading; uint source;
    vec3 normal; uint target;
    uint triangle; float rest; uint stays; uint cell;
};
struct Flow {
    uint wanted; uint limit; uint leaving; uint rest;
    uint listed; uint gained; uint mismatches;
    uint entries; uint left_over; uint most_wanted; uint refused; uint selected; uint arrived; uint crossed;
};
struct Physarum { float speed; float sensor_offset; float sensor_cos; float sensor_sin; float rotation_cos; float rotation_sin; float sensor_noise; float favourite_density; float gravity_weight; float decrowding_weight; float distance_weight; uint attempts; };
struct TrailRates { float diffusion; float deposit; float decay; float pad0; };
struct Shell { vec3 center; float radius; float narrow; float strength; float speed; float pad0; };
struct SurfaceSample { vec3 position; uint texel; };
struct SampleTile { vec3 center; float radius; };
struct ObjectPair { vec4 x; vec4 y; vec4 z; uint first_face; uint face_count; uint first_node; uint is_closed; };
struct TreeQuery { vec3 place; uint slot; vec3 end; float result; float u; float v; uint ended; uint pad0; };
struct DistanceJob { uint first_thread; uint first_sample; uint sample_count; uint first_pair; uint pair_count; uint first_tile; };
struct ListedTile { uint tile; uint first_sample; uint sample_count; uint first_pair; uint pair_count; uint hinted; uint pad0; uint pad1; };
struct Seam { uint source[4]; uint texel; uint weight[2]; uint pad0; };
struct ExchangeRow { uint texel; uint first; uint pair_count; uint counts_and_mask; float conductance; };
struct ExchangeEntry { uint texel; float weight; };

#endif
