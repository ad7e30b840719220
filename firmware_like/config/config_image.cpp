#include "firmware_like/config/config_image.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>
#include <string_view>
#include <type_traits>

#include "firmware_like/config/config_fields.hpp"
#include "firmware_like/config/crc32.hpp"

namespace vergence {
namespace {

struct Header {
  std::array<char, 8> magic{'V', 'E', 'R', 'G', 'C', 'F', 'G', '\n'};
  std::uint32_t byte_order = 0x01020304;
  std::uint32_t version = kImageVersion;
  std::uint32_t settings = 0;    // check sum of the table
  std::uint32_t body_bytes = 0;  // after the header
  std::uint32_t body_crc = 0;
  std::uint32_t header_crc = 0;  // of all before
};
static_assert(sizeof(Header) == 32 && std::is_trivially_copyable_v<Header>);
constexpr std::size_t kHeaderChecked = offsetof(Header, header_crc);

// One pass over everything serves writing and reading, so that both agree.
class Writer {
 public:
  explicit Writer(std::span<std::byte> room) : room_(room) {}

  template <typename T>
  void pass(T& value) {
    static_assert(std::is_arithmetic_v<T> || std::is_enum_v<T>);
    put(std::as_bytes(std::span(&value, 1)));
  }
  void put(std::span<const std::byte> bytes) {
    fits_ = fits_ && bytes.size() <= room_.size() - used_;
    if (!fits_) return;
    std::copy(bytes.begin(), bytes.end(), room_.begin() + static_cast<std::ptrdiff_t>(used_));
    used_ += bytes.size();
  }
  [[nodiscard]] bool good() const { return fits_; }
  [[nodiscard]] std::size_t used() const { return used_; }
  static constexpr bool kReads = false;

 private:
  std::span<std::byte> room_;
  std::size_t used_ = 0;
  bool fits_ = true;
};

class Reader {
 public:
  explicit Reader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  template <typename T>
  void pass(T& value) {
    static_assert(std::is_arithmetic_v<T> || std::is_enum_v<T>);
    fits_ = fits_ && sizeof(T) <= bytes_.size() - used_;
    if (!fits_) return;
    if constexpr (std::is_same_v<T, bool>) {
      value = bytes_[used_] != std::byte{0};  // any other bit pattern would be no bool
    } else {
      std::memcpy(&value, bytes_.data() + used_, sizeof(T));
    }
    used_ += sizeof(T);
  }
  [[nodiscard]] bool good() const { return fits_; }
  [[nodiscard]] std::size_t used() const { return used_; }
  static constexpr bool kReads = true;

 private:
  std::span<const std::byte> bytes_;
  std::size_t used_ = 0;
  bool fits_ = true;
};

struct Misfit {
  const char* section = nullptr;
  const char* key = "";
  const char* problem = "is outside its range";
};

template <typename Archive>
void pass_number(Archive& archive, const ConfigSection& section, const ConfigField& field,
                 ControllerConfig& config, Place place, Misfit& misfit) {
  double value = Archive::kReads ? 0 : field.get(config, place);
  archive.pass(value);
  if (!archive.good()) return;
  if (!is_in_range(field, value)) {
    if (misfit.section == nullptr) misfit = {section.name, field.key};
    return;
  }
  if constexpr (Archive::kReads) field.set(config, place, value);
}

template <typename Archive>
void pass_text(Archive& archive, const ConfigSection& section, const ConfigField& field,
               ControllerConfig& config, Place place, Misfit& misfit) {
  char* text = field.text(config, place);
  bool ended = false;
  for (std::size_t i = 0; i < field.capacity; ++i) {
    char letter = ended || Archive::kReads ? '\0' : text[i];
    archive.pass(letter);
    ended = ended || letter == '\0';
    if constexpr (Archive::kReads) text[i] = letter;
  }
  if (!ended && misfit.section == nullptr) misfit = {section.name, field.key, "does not end"};
}

// Of a list, as many as there are drives: the others have no values to judge.
int used(const ConfigSection& section, const ControllerConfig& config) {
  if (section.list == 0) return section.count();
  return config.robot.has_arm ? std::clamp(config.can.arm.axes, 0, section.list) : 0;
}

template <typename Archive>
void pass_fields(Archive& archive, ControllerConfig& config, Misfit& misfit) {
  archive.pass(config.can.arm.axes);
  for (const ConfigSection& section : config_sections()) {
    for (int instance = 0; instance < used(section, config); ++instance) {
      for (const ConfigField& field : section.fields) {
        for (int element = 0; element < field.count; ++element) {
          const Place place{instance, element};
          if (field.kind == FieldKind::kText) {
            pass_text(archive, section, field, config, place, misfit);
          } else {
            pass_number(archive, section, field, config, place, misfit);
          }
        }
      }
    }
  }
}

template <typename Archive, typename Matrix>
void pass_matrix(Archive& archive, Matrix& matrix) {
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    for (Eigen::Index j = 0; j < matrix.cols(); ++j) archive.pass(matrix(i, j));
  }
}

template <typename Archive>
void pass_transform(Archive& archive, Transform& T) {
  pass_matrix(archive, T.R);
  pass_matrix(archive, T.t_mm);
}

template <typename Archive, typename Array>
void pass_array(Archive& archive, Array& array) {
  for (auto& value : array) archive.pass(value);
}

template <typename Archive>
void pass_camera(Archive& archive, CameraModel& camera) {
  archive.pass(camera.width_px);
  archive.pass(camera.height_px);
  archive.pass(camera.fx_px);
  archive.pass(camera.fy_px);
  archive.pass(camera.cx_px);
  archive.pass(camera.cy_px);
  pass_array(archive, camera.distortion);
  pass_transform(archive, camera.T_H_C);
}

template <typename Archive>
void pass_limits(Archive& archive, JointLimits& limits) {
  archive.pass(limits.min_rad);
  archive.pass(limits.max_rad);
  archive.pass(limits.velocity_rad_per_s);
  archive.pass(limits.acceleration_rad_per_s2);
  archive.pass(limits.jerk_rad_per_s3);
}

template <typename Archive>
void pass_arm(Archive& archive, ControllerConfig& config) {
  SerialArm& arm = config.robot.arm;
  archive.pass(arm.joints);
  pass_transform(archive, arm.T_W_base);
  pass_transform(archive, arm.T_flange_hand);
  for (DhRow& link : arm.dh) {
    archive.pass(link.a_mm);
    archive.pass(link.alpha_rad);
    archive.pass(link.d_mm);
    archive.pass(link.theta_offset_rad);
  }
  for (JointLimits& limits : arm.limits) pass_limits(archive, limits);
  archive.pass(arm.held);
  pass_transform(archive, config.robot.T_W_H_fixed);
  // The bus's own guard, made from these.
  for (canopen::CanopenAxisConfig& axis : config.can.arm.axis) {
    archive.pass(axis.min_rad);
    archive.pass(axis.max_rad);
    archive.pass(axis.max_velocity_rad_per_s);
  }
}

template <typename Archive>
void pass_relation(Archive& archive, RobotConfig& robot) {
  pass_transform(archive, robot.relation.T_Ed_M);
  bool given = robot.R_W_M_given.has_value();
  archive.pass(given);
  Matrix3 R = given && !Archive::kReads ? *robot.R_W_M_given : Matrix3::Identity();
  pass_matrix(archive, R);
  if constexpr (Archive::kReads) robot.R_W_M_given = given ? std::optional<Matrix3>(R) : std::nullopt;
}

template <typename Archive>
void pass_tracker(Archive& archive, TrackerSettings& settings) {
  archive.pass(settings.method);
  pass_array(archive, settings.box.centre);
  pass_array(archive, settings.box.half_range);
  archive.pass(settings.ga.coding);
  archive.pass(settings.ga.survivors);
  archive.pass(settings.ga.mutation_per_1024);
  archive.pass(settings.last_stage);
  archive.pass(settings.hue_limits.dark_below);
  archive.pass(settings.hue_limits.bright_from);
  archive.pass(settings.hue_limits.min_saturation_permille);
  archive.pass(settings.follow_mm);
  archive.pass(settings.follow_e);
}

template <typename Archive>
void pass_marker(Archive& archive, MarkerModel& model) {
  archive.pass(model.balls);
  archive.pass(model.inner_samples);
  archive.pass(model.outer_samples);
  for (Ball& ball : model.ball) {
    pass_matrix(archive, ball.centre_mm);
    archive.pass(ball.radius_mm);
    archive.pass(ball.hue_deg);
    archive.pass(ball.tolerance_deg);
  }
  pass_array(archive, model.hue);
  pass_array(archive, model.tolerance);
  pass_array(archive, model.pattern_x);
  pass_array(archive, model.pattern_y);
}

template <typename Archive>
void pass_colours(Archive& archive, PointColours& colours) {
  pass_array(archive, colours.luma);
  pass_array(archive, colours.cb);
  pass_array(archive, colours.cr);
}

template <typename Archive>
void pass_photo(Archive& archive, PhotoModel& model) {
  archive.pass(model.inner);
  archive.pass(model.outer);
  archive.pass(model.masked);
  pass_array(archive, model.x_mm);
  pass_array(archive, model.y_mm);
  pass_array(archive, model.z_mm);
  pass_array(archive, model.hue);
  pass_array(archive, model.weight);
  for (PointColours& colours : model.colour) pass_colours(archive, colours);
  for (auto& share : model.backdrop.share) pass_array(archive, share);
  for (PointColours& colours : model.backdrop.colour) pass_colours(archive, colours);
  archive.pass(model.backdrop.mean.luma);
  archive.pass(model.backdrop.mean.cb);
  archive.pass(model.backdrop.mean.cr);
  archive.pass(model.backdrop.plain);
  pass_matrix(archive, model.optical_centre_mm);
  archive.pass(model.background_hue);
  archive.pass(model.votes.in_match);
  archive.pass(model.votes.in_background);
  archive.pass(model.votes.in_other);
  archive.pass(model.votes.out_background);
  archive.pass(model.votes.out_other);
  archive.pass(model.votes.in_tolerance_deg);
  archive.pass(model.votes.background_tolerance_deg);
  archive.pass(model.votes.out_tolerance_deg);
}

template <typename Archive>
void pass_all(Archive& archive, ControllerConfig& config, Misfit& misfit) {
  pass_fields(archive, config, misfit);
  pass_camera(archive, config.robot.rig.left);
  pass_camera(archive, config.robot.rig.right);
  for (v4l2::VideoConfig& eye : config.cameras.eyes) {
    archive.pass(eye.width_px);
    archive.pass(eye.height_px);
  }
  pass_arm(archive, config);
  pass_relation(archive, config.robot);
  pass_tracker(archive, config.robot.tracker);
  archive.pass(config.target);
  if (config.target == TargetKind::kMarker) {
    pass_marker(archive, config.marker);
  } else {
    pass_photo(archive, config.photo);
  }
}

// What is not in the table but must not be anything.
Misfit find_misfit(const ControllerConfig& config) {
  const auto within = [](int value, int low, int high) { return value >= low && value <= high; };
  if (config.target != TargetKind::kMarker && config.target != TargetKind::kPhoto) return {"model", "kind"};
  const MarkerModel& marker = config.marker;
  if (config.target == TargetKind::kMarker &&
      !(within(marker.balls, 1, kMaxBalls) && within(marker.inner_samples, 1, kMaxInnerSamples) &&
        within(marker.outer_samples, 1, kMaxOuterSamples))) {
    return {"model", "ball"};
  }
  const PhotoModel& photo = config.photo;
  if (config.target == TargetKind::kPhoto &&
      !(within(photo.inner, 1, kMaxPhotoPoints) && within(photo.outer, 0, kMaxPhotoPoints - photo.inner))) {
    return {"model", "photo"};
  }
  const TrackerSettings& tracker = config.robot.tracker;
  if (check(tracker.box) != Status::kOk) return {"search", "half_range"};
  if (!within(tracker.ga.survivors, 2, kPopulation - 1) || !within(tracker.ga.mutation_per_1024, 0, 1024)) {
    return {"search", "ga"};
  }
  if (config.robot.has_arm && validate(config.robot.arm) != Status::kOk) return {"arm", "joint"};
  return {};
}

std::uint32_t crc_of(std::string_view text, std::uint32_t crc) {
  return crc32(std::as_bytes(std::span(text.data(), text.size() + 1)), crc);
}

std::uint32_t crc_of_table() {
  std::uint32_t crc = 0;
  for (const ConfigSection& section : config_sections()) {
    crc = crc_of(section.name, crc);
    const auto count = static_cast<std::uint32_t>(section.count());
    crc = crc32(std::as_bytes(std::span(&count, 1)), crc);
    for (const ConfigField& field : section.fields) {
      crc = crc_of(field.key, crc);
      const std::array<std::uint32_t, 3> shape = {static_cast<std::uint32_t>(field.kind),
                                                  static_cast<std::uint32_t>(field.count),
                                                  static_cast<std::uint32_t>(field.capacity)};
      crc = crc32(std::as_bytes(std::span(shape)), crc);
      for (const char* const name : field.choices) crc = crc_of(name, crc);
    }
  }
  return crc;
}

std::uint32_t crc_of(const Header& header) {
  return crc32(std::as_bytes(std::span(&header, 1)).first(kHeaderChecked));
}

ImageStatus check_header(std::span<const std::byte> image, Header& header) {
  const Header ours;
  const std::size_t begun = std::min(image.size(), ours.magic.size());
  if (begun > 0 && std::memcmp(image.data(), ours.magic.data(), begun) != 0) {
    return ImageStatus::kNotAnImage;
  }
  if (image.size() < sizeof(Header)) return ImageStatus::kTruncated;
  std::memcpy(&header, image.data(), sizeof header);
  if (header.byte_order != ours.byte_order) return ImageStatus::kWrongByteOrder;
  if (header.header_crc != crc_of(header)) return ImageStatus::kCorrupted;
  if (header.version != ours.version) return ImageStatus::kOtherVersion;
  if (header.settings != crc_of_table()) return ImageStatus::kOtherSettings;
  if (image.size() - sizeof(Header) < header.body_bytes) return ImageStatus::kTruncated;
  if (image.size() - sizeof(Header) > header.body_bytes) return ImageStatus::kWrongSize;
  const std::span<const std::byte> body = image.subspan(sizeof(Header));
  return crc32(body) == header.body_crc ? ImageStatus::kOk : ImageStatus::kCorrupted;
}

}  // namespace

const char* describe(ImageStatus status) {
  switch (status) {
    case ImageStatus::kOk: return "no error";
    case ImageStatus::kTruncated: return "the file ends too early: copy or build it again";
    case ImageStatus::kNotAnImage: return "this is no configuration image: `vergence config build` makes one";
    case ImageStatus::kWrongByteOrder:
      return "it was built on a machine of another byte order: build it on one like this";
    case ImageStatus::kOtherVersion:
      return "it was built by another version: build it again with this one's `vergence config build`";
    case ImageStatus::kOtherSettings:
      return "its settings are not those of this program: build it again with the `vergence` it came with";
    case ImageStatus::kWrongSize: return "its length is not what it says: copy or build it again";
    case ImageStatus::kCorrupted: return "its check sum is wrong: copy or build it again";
    case ImageStatus::kBadValue: return "a setting cannot be";
    case ImageStatus::kTooSmall: return "there is not enough room for it";
  }
  return "unknown error";
}

ImageResult write_image(const ControllerConfig& config, std::span<std::byte> room) {
  if (room.size() < sizeof(Header)) return {ImageStatus::kTooSmall};
  Writer writer(room.subspan(sizeof(Header)));
  Misfit misfit;
  // The pass takes what it could also fill; a writer only looks, but for the bytes behind a text's end.
  pass_all(writer, const_cast<ControllerConfig&>(config), misfit);
  if (!writer.good()) return {ImageStatus::kTooSmall};
  if (misfit.section != nullptr) {
    return {ImageStatus::kBadValue, 0, misfit.section, misfit.key, misfit.problem};
  }
  Header header;
  header.settings = crc_of_table();
  header.body_bytes = static_cast<std::uint32_t>(writer.used());
  header.body_crc = crc32(room.subspan(sizeof(Header), writer.used()));
  header.header_crc = crc_of(header);
  std::memcpy(room.data(), &header, sizeof header);
  return {ImageStatus::kOk, sizeof(Header) + writer.used()};
}

ImageResult read_image(std::span<const std::byte> image, ControllerConfig& config) {
  Header header;
  if (const ImageStatus status = check_header(image, header); status != ImageStatus::kOk) return {status};
  Reader reader(image.subspan(sizeof(Header)));
  Misfit misfit;
  pass_all(reader, config, misfit);
  if (!reader.good() || reader.used() != header.body_bytes) return {ImageStatus::kWrongSize};
  if (misfit.section == nullptr) misfit = find_misfit(config);
  if (misfit.section != nullptr) {
    return {ImageStatus::kBadValue, image.size(), misfit.section, misfit.key, misfit.problem};
  }
  if (const ConfigConflict conflict = find_conflict(config); conflict.problem[0] != '\0') {
    return {ImageStatus::kBadValue, image.size(), conflict.section, conflict.key, conflict.problem};
  }
  return {ImageStatus::kOk, image.size()};
}

}  // namespace vergence
