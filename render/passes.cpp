#include "render/passes.h"

namespace firn {

void Renderer::Passes::set_view(const Program& program, const View& view) const {
    program.set("eye", view.eye);
    program.set("basis", view.basis);
    program.set("samples", Eigen::Vector2f(view.samples.cast<float>()));
    program.set("sample_tan", view.sample_tan);
    program.set("near_depth", view.near_depth);
    program.set("projection", view.projection());
    program.set("max_point_size", max_point_size);
}

/// A lens spreads light, not what the film makes of it; colours of a map are no light.
static bool undeveloped(const Frame& frame) { return frame.aperture > 0 && !frame.coloured; }

void Renderer::Passes::set_light(const Program& program, const Frame& frame) const {
    program.set("shadow_all", unit_shadow_all);
    program.set("shadow_bodies", unit_shadow_bodies);
    program.set("shadow_depths", unit_shadow_depths);
    program.set("spray_shadow", unit_spray_shadow);
    program.set("shadow_bounds", unit_shadow_bounds);
    program.set("snow_light", unit_snow_light);
    program.set("volume_origin", frame.volume_origin);
    program.set("volume_size", frame.volume_size);
    program.set("shadow_matrix", frame.shadow.matrix);
    program.set("shadow_texel", frame.shadow.texel);
    program.set("shadow_span", frame.shadow.texel * static_cast<float>(effort.shadow_size));
    program.set("shadow_reach", frame.shadow.texel * static_cast<float>(effort.shadow_size / bounds_across));
    program.set("shadow_search", effort.shadow_search);
    program.set("shadow_taps", effort.shadow_taps);
    program.set("shadow_far", unit_shadow_far);
    program.set("far_matrix", frame.far_shadow.value_or(frame.shadow).matrix);
    program.set("far_texel", frame.far_shadow ? frame.far_shadow->texel : 0.0f);
    program.set("to_sun", frame.to_sun);
    program.set("sun_light", frame.light.sun);
    program.set("sky_light", frame.light.sky);
    program.set("ground", frame.ground);
    program.set("sky_horizon", frame.light.horizon);
    program.set("sky_zenith", frame.light.zenith);
    program.set("spacing", frame.spacing);
    program.set("haze_distance", frame.view.haze_distance);
    program.set("exposure", static_cast<float>(picture.exposure));
    program.set("undeveloped", undeveloped(frame));
}

void Renderer::Passes::set_bodies(const Program& program, const BodyDistances& bodies) const {
    program.set("body_a[0]", bodies.a);
    program.set("body_b[0]", bodies.b);
    program.set("body_colour[0]", bodies.colour);
    program.set("body_reach", bodies.reach);
}

}  // namespace firn
