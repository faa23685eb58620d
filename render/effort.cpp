#include "render/effort.h"

namespace firn {

Effort effort_of(Quality quality) {
    switch (quality) {
        case Quality::draft:
            return {.edge = 0.4,
                    .least_radius = 1.75f,
                    .least_thrower = 2.5f,
                    .shadow_size = 512,
                    .shadow_search = 5,
                    .shadow_taps = 5,
                    .children = 0,
                    .children_from = 2.5f,
                    .all_children = 0,
                    .puffs = 0.25f,
                    .grains = 1,
                    .fine_light = false};
        case Quality::preview:
            return {.edge = 1,
                    .least_radius = 1.3f,
                    .least_thrower = 2.5f,
                    .shadow_size = 1024,
                    .shadow_search = 6,
                    .shadow_taps = 8,
                    .children = 8,
                    .children_from = 3.5f,
                    .all_children = 220'000,
                    .puffs = 0.25f,
                    .grains = 2,
                    .fine_light = false};
        default:
            return {.edge = 2,
                    .least_radius = 0.8f,
                    .least_thrower = 1.7f,
                    .shadow_size = 2048,
                    .shadow_search = 8,
                    .shadow_taps = 16,
                    .children = 10,
                    .children_from = 3.2f,
                    .all_children = 280'000,
                    .puffs = 0.8f,
                    .grains = 3,
                    .fine_light = true};
    }
}

}  // namespace firn
