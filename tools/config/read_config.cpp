#include "tools/config/read_config.hpp"

#include <linux/videodev2.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "firmware_like/config/config_fields.hpp"
#include "firmware_like/pipeline.hpp"
#include "tools/config/show_config.hpp"
#include "tools/io/arm_file.hpp"
#include "tools/io/dataset.hpp"
#include "tools/io/input_error.hpp"
#include "tools/io/toml_reader.hpp"

namespace vergence::tools {
namespace {

std::string range_of(const ConfigField& field) {
  const auto shown = [](double value) {
    std::string text = std::to_string(value);
    text.erase(text.find_last_not_of('0') + 1);
    if (text.back() == '.') text.pop_back();
    return text;
  };
  return "from " + shown(field.low) + " to " + shown(field.high);
}

std::string list_of(const ConfigField& field) {
  std::string list;
  for (const char* const name : field.choices) list += (list.empty() ? "" : ", ") + std::string(name);
  return list;
}

std::vector<double> written_numbers(const TomlReader& table, const ConfigField& field) {
  const auto count = static_cast<std::size_t>(field.count);
  return field.count > 1 ? table.numbers(field.key, count) : std::vector<double>{table.number(field.key)};
}

void take_numbers(const TomlReader& table, const ConfigField& field, int instance, ControllerConfig& config) {
  const std::vector<double> values = written_numbers(table, field);
  for (int element = 0; element < field.count; ++element) {
    const double value = values[static_cast<std::size_t>(element)];
    if (value < field.low || value > field.high) {
      table.fail(field.key, "is outside its range", range_of(field));
    }
    if (field.kind == FieldKind::kInteger && value != std::floor(value)) {
      table.fail(field.key, "is not a whole number", range_of(field));
    }
    field.set(config, {instance, element}, value * field.scale);
  }
  for (int element = 0; element < field.count; ++element) {
    const double kept = field.get(config, {instance, element}) / field.scale;
    const double written = values[static_cast<std::size_t>(element)];
    // Times are kept in whole nanoseconds.
    const double grain = std::max(1e-9, field.scale > 1 ? 1 / field.scale : 0);
    if (std::abs(kept - written) > 1e-9 * std::abs(written) + grain) {
      table.fail(field.key, "cannot be", "the squares of a quaternion's vector part add up to 1 at most");
    }
  }
}

void take_text(const TomlReader& table, const ConfigField& field, int instance, ControllerConfig& config) {
  const std::string value = table.text(field.key);
  if (value.size() >= field.capacity) {
    table.fail(field.key, "is too long", "at most " + std::to_string(field.capacity - 1) + " bytes");
  }
  if (value.find('\0') != std::string::npos) table.fail(field.key, "holds a zero byte");
  char* text = field.text(config, {instance, 0});
  std::fill_n(text, field.capacity, '\0');
  std::copy(value.begin(), value.end(), text);
}

void take(const TomlReader& table, const ConfigField& field, int instance, ControllerConfig& config) {
  switch (field.kind) {
    case FieldKind::kNumber:
    case FieldKind::kInteger: return take_numbers(table, field, instance, config);
    case FieldKind::kFlag:
      return field.set(config, {instance, 0}, table.boolean_or(field.key, false) ? 1 : 0);
    case FieldKind::kText: return take_text(table, field, instance, config);
    case FieldKind::kChoice: break;
  }
  const std::string value = table.text(field.key);
  const auto found = std::find(field.choices.begin(), field.choices.end(), value);
  if (found == field.choices.end()) table.fail(field.key, "is '" + value + "'", "one of " + list_of(field));
  field.set(config, {instance, 0}, static_cast<double>(found - field.choices.begin()));
}

// The table of a section, [a.b] as well.
TomlReader table_of(const TomlReader& root, const ConfigSection& section) {
  return root.table_or_empty(section.name);
}

void take_all(const TomlReader& table, const ConfigSection& section, int instance, ControllerConfig& config) {
  for (const ConfigField& field : section.fields) {
    if (table.has(field.key)) take(table, field, instance, config);
  }
}

void take_instances(const TomlReader& table, const ConfigSection& section, ControllerConfig& config) {
  for (int i = 0; i < section.count(); ++i) {
    take_all(table, section, i, config);  // what they share
    take_all(table.table_or_empty(section.instances[static_cast<std::size_t>(i)]), section, i, config);
  }
}

void require_axis(const TomlReader& axis) {
  for (const char* const key : {"node", "counts_per_turn"}) {
    if (!axis.has(key)) axis.fail(key, "missing", "every drive has its own");
  }
}

void take_axes(const TomlReader& can, const ConfigSection& section, ControllerConfig& config) {
  if (!config.robot.has_arm) return;
  const std::vector<TomlReader> axes = can.tables("axis");
  if (axes.size() != static_cast<std::size_t>(config.robot.arm.joints)) {
    can.fail("axis",
             "there are " + std::to_string(axes.size()) + " but the arm has " +
                 std::to_string(config.robot.arm.joints) + " joints",
             "one [[can.axis]] for each, from the base");
  }
  for (std::size_t i = 0; i < axes.size(); ++i) {
    require_axis(axes[i]);
    take_all(axes[i], section, static_cast<int>(i), config);
    canopen::CanopenAxisConfig& axis = config.can.arm.axis[i];
    if (axis.bus > 0 && config.can.interface_2[0] == '\0') {
      axes[i].fail("bus", "is 2, but there is one bus", "name the other's can.interface_2, or say 1");
    }
    if (axis.counts_per_rad == 0) axes[i].fail("counts_per_turn", "is 0");
    if (!axes[i].has("velocity_units_per_turn_per_s"))
      axis.velocity_units_per_rad_per_s = axis.counts_per_rad;
    const JointLimits& limits = config.robot.arm.limits[i];
    axis.min_rad = limits.min_rad;
    axis.max_rad = limits.max_rad;
    axis.max_velocity_rad_per_s = limits.velocity_rad_per_s;
  }
  config.can.arm.axes = static_cast<int>(axes.size());
}

// Keys of a table are those of all sections that share its name, their instances, and lists within.
void refuse_unknown(const TomlReader& root) {
  std::vector<std::string_view> tables = {"rig", "model", "search", "arm"};
  for (const ConfigSection& section : config_sections()) {
    const std::string_view name = section.name;
    if (section.list > 0) continue;
    tables.push_back(name);
    std::vector<std::string_view> keys;
    for (const ConfigSection& other : config_sections()) {
      const std::string_view other_name = other.name;
      if (other_name == name) {
        for (const ConfigField& field : other.fields) keys.push_back(field.key);
        for (const char* const instance : other.instances) keys.push_back(instance);
      } else if (other.list > 0 && other_name.starts_with(std::string(name) + ".")) {
        keys.push_back(other_name.substr(name.size() + 1));
      }
    }
    root.table_or_empty(name).allow_only(keys);
    std::vector<std::string_view> own;
    for (const ConfigField& field : section.fields) own.push_back(field.key);
    for (const char* const instance : section.instances) {
      root.table_or_empty(name).table_or_empty(instance).allow_only(own);
    }
  }
  root.allow_only(tables);
}

void refuse_unknown_axis_keys(const TomlReader& can, const ConfigSection& section) {
  std::vector<std::string_view> keys;
  for (const ConfigField& field : section.fields) keys.push_back(field.key);
  for (const TomlReader& axis : can.tables("axis", true)) axis.allow_only(keys);
}

void read_files(const TomlReader& root, ControllerConfig& config) {
  const std::filesystem::path beside = root.file().parent_path();
  const std::filesystem::path model = beside / root.text("model");
  Dataset dataset;
  dataset.directory = beside;
  dataset.target = read_target(model);
  dataset.rig = read_rig(beside / root.text("rig"));
  config.target = dataset.target.kind;
  config.robot.rig = dataset.rig;
  config.robot.tracker = default_settings(Method::kVergence, dataset.target.kind);
  if (root.has("search")) config.robot.tracker.box = read_search_box(beside / root.text("search"));
  if (root.has("arm")) config.robot.arm = read_arm(beside / root.text("arm"));
  if (config.target == TargetKind::kMarker) {
    build_model(dataset, MarkerOptions{}, config.marker);
  } else {
    build_model(dataset, PhotoOptions{}, config.robot.tracker.hue_limits, config.photo);
  }
  for (std::size_t i = 0; i < 2; ++i) {
    const CameraModel& camera = i == 0 ? dataset.rig.left : dataset.rig.right;
    config.cameras.eyes[i].width_px = camera.width_px;
    config.cameras.eyes[i].height_px = camera.height_px;
  }
}

void refuse_conflicts(const TomlReader& root, const ControllerConfig& config) {
  if (const ConfigConflict conflict = find_conflict(config); conflict.problem[0] != '\0') {
    const TomlReader table = root.table_or_empty(conflict.section);
    if (conflict.key[0] == '\0') root.fail(conflict.section, conflict.problem);
    const bool is_load = std::string_view(conflict.key) == "bitrate_bit_per_s";
    std::string loads;
    for (const std::string& load : is_load ? bus_loads(config) : std::vector<std::string>{}) {
      loads += (loads.empty() ? "" : "; ") + load;
    }
    table.fail(conflict.key, conflict.problem, loads);
  }
  // What only the parts themselves can say.
  const auto pipeline = std::make_unique<Pipeline>();
  const Status status = config.target == TargetKind::kMarker
                            ? pipeline->configure(config.robot, config.marker)
                            : pipeline->configure(config.robot, config.photo);
  if (status != Status::kOk) throw InputError(root.file(), "", describe(status));
}

}  // namespace

std::unique_ptr<ControllerConfig> default_config() {
  auto config = std::make_unique<ControllerConfig>();
  config->robot.relation.T_Ed_M.t_mm = {0, -90, 545};  // [Sect. 4.1]
  for (v4l2::VideoConfig& eye : config->cameras.eyes) {
    eye.fourcc = V4L2_PIX_FMT_YUYV;
    eye.interval = {1, 30};
  }
  for (step::MotorConfig& motor : config->motors.motors) {
    motor.timing.max_rate_millisteps_per_s = 4'000 * step::kMillistepsPerStep;
    motor.timing.acceleration_millisteps_per_s2 = 80'000 * step::kMillistepsPerStep;
  }
  config->robot.eye_control.steps_per_rad.fill(1000);
  for (JointLimits& limits : config->robot.eye_limits) limits.jerk_rad_per_s3 = 15'000;
  return config;
}

std::unique_ptr<ControllerConfig> read_config(const std::filesystem::path& file) {
  const TomlReader root = TomlReader::from_file(file);
  refuse_unknown(root);
  auto config = default_config();
  read_files(root, *config);
  for (const ConfigSection& section : config_sections()) {
    if (section.list > 0) {
      const TomlReader can = root.table_or_empty("can");
      refuse_unknown_axis_keys(can, section);
      take_axes(can, section, *config);
    } else if (section.instances.empty()) {
      take_all(table_of(root, section), section, 0, *config);
    } else {
      take_instances(table_of(root, section), section, *config);
    }
  }
  refuse_conflicts(root, *config);
  return config;
}

}  // namespace vergence::tools
