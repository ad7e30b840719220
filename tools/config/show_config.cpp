#include "tools/config/show_config.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "firmware_like/config/config_fields.hpp"
#include "hal/canopen/bus_load.hpp"
#include "hal/clock.hpp"
#include "hal/gpio_step/step_timing.hpp"
#include "tools/config/read_config.hpp"

namespace vergence::tools {
namespace {

std::string shown(double value) {
  std::ostringstream out;
  out.precision(12);
  out << value;
  return out.str();
}

std::string between(const char* before, const std::string& text, const char* after) {
  std::string result = before;
  result += text;
  result += after;
  return result;
}

std::string value_of(const ConfigField& field, const ControllerConfig& config, int instance) {
  if (field.kind == FieldKind::kText) {
    // The accessor only looks.
    return between("\"", field.text(const_cast<ControllerConfig&>(config), {instance, 0}), "\"");
  }
  std::string list;
  for (int element = 0; element < field.count; ++element) {
    const double kept = field.get(config, {instance, element});
    std::string one = shown(std::round(kept / field.scale * 1e9) / 1e9);
    if (field.kind == FieldKind::kFlag) one = kept != 0 ? "true" : "false";
    if (field.kind == FieldKind::kChoice) {
      const auto index = static_cast<std::size_t>(kept);
      one = between("\"", kept >= 0 ? field.choices[index] : "?", "\"");
    }
    if (element > 0) list += ", ";
    list += one;
  }
  return field.count > 1 ? between("[", list, "]") : list;
}

void show_section(std::ostringstream& out, const ConfigSection& section, const ControllerConfig& config,
                  const ControllerConfig& defaults, int instance) {
  for (const ConfigField& field : section.fields) {
    const std::string value = value_of(field, config, instance);
    std::string line = std::string(field.key) + " = " + value;
    line.resize(std::max<std::size_t>(line.size() + 2, 44), ' ');
    const bool changed = value != value_of(field, defaults, instance);
    out << line << "# " << (changed ? "" : "(default) ") << field.meaning << '\n';
  }
}

void show_derived(std::ostringstream& out, const ControllerConfig& config) {
  const StereoRig& rig = config.robot.rig;
  out << "\n# From other files\n";
  out << "# target   "
      << (config.target == TargetKind::kMarker ? "marker of " + std::to_string(config.marker.balls) + " balls"
                                               : "photo-model of " + std::to_string(config.photo.inner) +
                                                     " + " + std::to_string(config.photo.outer) + " points")
      << '\n';
  out << "# cameras  " << rig.left.width_px << " x " << rig.left.height_px << ", fx " << shown(rig.left.fx_px)
      << " and " << shown(rig.right.fx_px) << " px\n";
  if (config.robot.has_arm) {
    out << "# arm      " << config.robot.arm.joints << " joints\n";
    for (const std::string& load : bus_loads(config)) out << "# " << load << '\n';
  }
  if (config.robot.has_eyes) {
    for (std::size_t i = 0; i < kEyeMotors; ++i) {
      const auto& timing = config.motors.motors[i].timing;
      out << "# motor " << i + 1 << "  could make "
          << step::fastest_rate_millisteps_per_s(timing) / step::kMillistepsPerStep
          << " steps/s with its pulses and jitter\n";
    }
  }
}

std::string default_of(const ConfigField& field, const ControllerConfig& defaults) {
  return value_of(field, defaults, 0);
}

std::string range_of(const ConfigField& field) {
  switch (field.kind) {
    case FieldKind::kNumber:
    case FieldKind::kInteger: return shown(field.low) + " to " + shown(field.high);
    case FieldKind::kFlag: return "true, false";
    case FieldKind::kText: return "up to " + std::to_string(field.capacity - 1) + " bytes";
    case FieldKind::kChoice: break;
  }
  std::string list;
  for (const char* const name : field.choices) {
    if (!list.empty()) list += ", ";
    list += name;
  }
  return list;
}

std::string title_of(const ConfigSection& section) {
  std::string title;
  if (section.list > 0) return between("[[", section.name, "]]");
  if (section.instances.empty()) return between("[", section.name, "]");
  for (const char* const instance : section.instances) {
    if (!title.empty()) title += ", ";
    title += between("[", between(section.name, ".", instance), "]");
  }
  return title;
}

}  // namespace

std::string show_config(const ControllerConfig& config) {
  std::ostringstream out;
  const auto defaults = default_config();
  for (const ConfigSection& section : config_sections()) {
    const int count = section.list > 0 ? config.can.arm.axes : section.count();
    if (section.list > 0 && !config.robot.has_arm) continue;
    for (int i = 0; i < count; ++i) {
      const std::string name = section.name;
      if (section.list > 0) {
        out << "\n[[" << name << "]]\n";
      } else if (section.instances.empty()) {
        out << "\n[" << name << "]\n";
      } else {
        out << "\n[" << name << '.' << section.instances[static_cast<std::size_t>(i)] << "]\n";
      }
      show_section(out, section, config, *defaults, i);
    }
  }
  show_derived(out, config);
  return out.str();
}

std::vector<std::string> bus_loads(const ControllerConfig& config) {
  std::vector<std::string> loads;
  if (!config.robot.has_arm) return loads;
  const canopen::CanopenArmConfig& arm = config.can.arm;
  for (int bus = 0; bus < canopen::bus_count(arm); ++bus) {
    const auto axes =
        std::count_if(arm.axis.begin(), arm.axis.begin() + arm.axes,
                      [bus](const canopen::CanopenAxisConfig& axis) { return axis.bus == bus; });
    const auto permille =
        static_cast<double>(canopen::bus_load_permille(arm, bus, config.can.bitrate_bit_per_s));
    const auto rate_Hz = static_cast<double>(kNsPerSecond) / static_cast<double>(arm.sync_period_ns);
    loads.push_back(between("bus ", std::to_string(bus + 1), ", ") + config.can.interface_of(bus) + ": " +
                    std::to_string(axes) + " axes at " + shown(rate_Hz) + " Hz, loaded by " +
                    shown(0.1 * permille) + " % at worst");
  }
  return loads;
}

std::string describe_settings() {
  std::ostringstream out;
  const auto defaults = default_config();
  for (const ConfigSection& section : config_sections()) {
    out << "\n### `" << title_of(section) << "`: " << section.meaning << "\n\n";
    out << "| key | default | may be | meaning |\n|---|---|---|---|\n";
    for (const ConfigField& field : section.fields) {
      out << "| `" << field.key << "` | " << default_of(field, *defaults) << " | " << range_of(field) << " | "
          << field.meaning << " |\n";
    }
  }
  return out.str();
}

}  // namespace vergence::tools
