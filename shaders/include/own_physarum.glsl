// own_physarum: what particles do on the object that one is on: the values of `params`, or the object's own.
// Twin: `physarum_on` of src/sim/twin/advance.rs.
// The includer declares OWN_PHYSARUM, `physarums`, `params` and what strip_table.glsl asks for first.

#ifndef MYXO_OWN_PHYSARUM
#define MYXO_OWN_PHYSARUM

float own_speed;
float own_sensor_offset;
float own_sensor_cos;
float own_sensor_sin;
float own_rotation_cos;
float own_rotation_sin;
float own_sensor_noise;
float own_favourite_density;
float own_gravity_weight;
float own_decrowding_weight;
float own_distance_weight;

#define OF_OBJECT(field) (OWN_PHYSARUM ? physarums[object].field : params.field)

void take_physarum(uint triangle) {
    uint object = OWN_PHYSARUM ? shape_words(triangle).w : 0u;
    own_speed = OF_OBJECT(speed);
    own_sensor_offset = OF_OBJECT(sensor_offset);
    own_sensor_cos = OF_OBJECT(sensor_cos);
    own_sensor_sin = OF_OBJECT(sensor_sin);
    own_rotation_cos = OF_OBJECT(rotation_cos);
    own_rotation_sin = OF_OBJECT(rotation_sin);
    own_sensor_noise = OF_OBJECT(sensor_noise);
    own_favourite_density = OF_OBJECT(favourite_density);
    own_gravity_weight = OF_OBJECT(gravity_weight);
    own_decrowding_weight = OF_OBJECT(decrowding_weight);
    own_distance_weight = OF_OBJECT(distance_weight);
}

#endif
