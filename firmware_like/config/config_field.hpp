// One setting of the controller: what it is called in TOML, what it may be, what it means, and where it is
// kept. The table of all of them (config_fields.hpp) drives reading, checking, showing and storing, so that a
// new setting is one row.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <tuple>
#include <type_traits>

#include "firmware_like/config/controller_config.hpp"

namespace vergence {

enum class FieldKind : std::uint8_t {
  kNumber,
  kInteger,
  kFlag,
  kChoice,  // the position in `choices`
  kText,
};

struct Place {
  int instance = 0;  // which eye, axis or motor
  int element = 0;   // of a field with several values
};

struct ConfigField {
  const char* key;
  FieldKind kind;
  const char* meaning;
  int count = 1;
  // As written; a number in TOML times `scale` is the number that is kept.
  double low = 0;
  double high = 0;
  double scale = 1;
  std::span<const char* const> choices{};
  // Every number is kept in the image as a double, which holds all the integers there are here.
  double (*get)(const ControllerConfig&, Place) = nullptr;
  void (*set)(ControllerConfig&, Place, double) = nullptr;
  // Of a text: zero-terminated, `capacity` with the zero.
  char* (*text)(ControllerConfig&, Place) = nullptr;
  std::size_t capacity = 0;
};

// A table of TOML: [name], or [name.instance] for each of the named instances, or [[name]] for a list.
struct ConfigSection {
  const char* name;
  const char* meaning;
  std::span<const char* const> instances{};
  int list = 0;  // longest list; 0: none
  std::span<const ConfigField> fields{};

  [[nodiscard]] constexpr int count() const {
    if (list > 0) return list;
    return instances.empty() ? 1 : static_cast<int>(instances.size());
  }
};

// Accessors are lambdas without capture: (config, place) -> reference.
template <typename Accessor>
using Accessed = std::remove_reference_t<std::invoke_result_t<Accessor, ControllerConfig&, Place>>;

template <typename Accessor>
constexpr ConfigField field_at(const char* key, FieldKind kind, const char* meaning, Accessor) {
  ConfigField field{key, kind, meaning};
  if constexpr (std::is_enum_v<Accessed<Accessor>> || std::is_arithmetic_v<Accessed<Accessor>>) {
    field.get = [](const ControllerConfig& config, Place place) {
      // The accessor only looks.
      return static_cast<double>(Accessor{}(const_cast<ControllerConfig&>(config), place));
    };
    field.set = [](ControllerConfig& config, Place place, double value) {
      using Kept = Accessed<Accessor>;
      if constexpr (std::is_floating_point_v<Kept> || std::is_same_v<Kept, bool>) {
        Accessor{}(config, place) = static_cast<Kept>(value);
      } else {
        Accessor{}(config, place) = static_cast<Kept>(std::llround(value));
      }
    };
  }
  return field;
}

template <typename Accessor>
constexpr ConfigField number(const char* key, double low, double high, const char* meaning, Accessor at,
                             double scale = 1) {
  ConfigField field = field_at(key, FieldKind::kNumber, meaning, at);
  field.low = low;
  field.high = high;
  field.scale = scale;
  return field;
}

template <typename Accessor>
constexpr ConfigField numbers(const char* key, int count, double low, double high, const char* meaning,
                              Accessor at, double scale = 1) {
  ConfigField field = number(key, low, high, meaning, at, scale);
  field.count = count;
  return field;
}

template <typename Accessor>
constexpr ConfigField integer(const char* key, double low, double high, const char* meaning, Accessor at) {
  ConfigField field = field_at(key, FieldKind::kInteger, meaning, at);
  field.low = low;
  field.high = high;
  return field;
}

template <typename Accessor>
constexpr ConfigField flag(const char* key, const char* meaning, Accessor at) {
  ConfigField field = field_at(key, FieldKind::kFlag, meaning, at);
  field.high = 1;
  return field;
}

template <typename Accessor>
constexpr ConfigField choice(const char* key, std::span<const char* const> choices, const char* meaning,
                             Accessor at) {
  ConfigField field = field_at(key, FieldKind::kChoice, meaning, at);
  field.choices = choices;
  field.high = static_cast<double>(choices.size()) - 1;
  return field;
}

template <typename Accessor>
constexpr ConfigField text(const char* key, const char* meaning, Accessor) {
  ConfigField field{key, FieldKind::kText, meaning};
  field.text = [](ControllerConfig& config, Place place) { return Accessor{}(config, place).data(); };
  field.capacity = std::tuple_size_v<Accessed<Accessor>>;
  return field;
}

}  // namespace vergence
