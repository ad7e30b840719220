// All settings of the controller.
#pragma once

#include <span>

#include "firmware_like/config/config_field.hpp"

namespace vergence {

[[nodiscard]] std::span<const ConfigSection> config_sections();

// Whether what is kept in a field may be there: finite, in its range, whole where it must be.
[[nodiscard]] bool is_in_range(const ConfigField& field, double kept);

// Two settings that do not go together; an empty text: none.
struct ConfigConflict {
  const char* section = "";
  const char* key = "";
  const char* problem = "";
};
[[nodiscard]] ConfigConflict find_conflict(const ControllerConfig& config);

}  // namespace vergence
