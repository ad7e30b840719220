#include "tools/controller/black_box_reader.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <memory>
#include <vector>

#include "firmware_like/daemon/black_box.hpp"
#include "tools/controller/record_table.hpp"
#include "tools/io/image_file.hpp"
#include "tools/io/input_error.hpp"
#include "tools/io/writable.hpp"

namespace vergence::tools {
namespace {

std::vector<char> read_all(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw InputError(file, "", "cannot be read");
  std::vector<char> bytes(kBoxFileBytes + 1);
  in.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  bytes.resize(static_cast<std::size_t>(in.gcount()));
  return bytes;
}

BoxHeader header_of(const std::filesystem::path& file, const std::vector<char>& bytes) {
  BoxHeader header;
  const BoxHeader ours;
  if (bytes.size() < sizeof header) throw InputError(file, "", "is too short to be a black box");
  std::memcpy(&header, bytes.data(), sizeof header);
  if (header.magic != ours.magic)
    throw InputError(file, "", "is no black box", "vergenced names them when it writes one");
  if (header.version != ours.version || header.record_bytes != ours.record_bytes ||
      header.pair_bytes != ours.pair_bytes) {
    throw InputError(file, "version", "is of another version",
                     "read it with the vergence that came with its vergenced");
  }
  if (header.records > kBoxRecords || header.pairs > kBoxPictures) {
    throw InputError(file, "records", "says it holds more than any does");
  }
  const std::size_t size =
      sizeof header + header.records * sizeof(TelemetryRecord) + header.pairs * sizeof(BoxPair);
  if (bytes.size() != size) throw InputError(file, "", "was cut short", "copy it again");
  const auto body = std::as_bytes(std::span(bytes)).subspan(sizeof header);
  if (crc_of_box(header, body) != header.crc)
    throw InputError(file, "", "is corrupted: its check sum is wrong", "copy it again");
  return header;
}

std::uint8_t to_byte(double value) {
  return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 255.0)));
}

RgbImage picture_of(const BoxPicture& picture) {
  RgbImage image(kBoxPictureWidth, kBoxPictureHeight);
  for (std::size_t i = 0; i < BoxPicture::kPixels; ++i) {
    const double y = picture.luma[i];
    const double cb = picture.cb[i] - 128.0;
    const double cr = picture.cr[i] - 128.0;
    image.data[3 * i] = to_byte(y + 1.402 * cr);
    image.data[3 * i + 1] = to_byte(y - 0.344136 * cb - 0.714136 * cr);
    image.data[3 * i + 2] = to_byte(y + 1.772 * cb);
  }
  return image;
}

void write_log(const std::filesystem::path& file, const char* records, std::size_t count) {
  std::ofstream out(file);
  out.precision(12);
  const std::vector<std::string>& columns = record_columns();
  for (std::size_t i = 0; i < columns.size(); ++i) out << (i > 0 ? "," : "") << columns[i];
  out << '\n';
  for (std::size_t k = 0; k < count; ++k) {
    TelemetryRecord record;
    std::memcpy(static_cast<void*>(&record), records + k * sizeof record, sizeof record);
    const std::vector<double> values = record_values(record);
    for (std::size_t i = 0; i < values.size(); ++i) out << (i > 0 ? "," : "") << values[i];
    out << '\n';
  }
  if (!out) throw InputError(file, "", "cannot be written");
}

}  // namespace

BoxSummary unpack_black_box(const std::filesystem::path& file, const std::filesystem::path& out) {
  const std::vector<char> bytes = read_all(file);
  const BoxHeader header = header_of(file, bytes);
  make_directory(out / "pictures");
  const char* next = bytes.data() + sizeof header;
  write_log(out / "log.csv", next, header.records);
  next += header.records * sizeof(TelemetryRecord);
  const auto pair = std::make_unique<BoxPair>();
  for (std::size_t k = 0; k < header.pairs; ++k) {
    std::memcpy(static_cast<void*>(pair.get()), next + k * sizeof(BoxPair), sizeof(BoxPair));
    std::array<char, 32> name{};
    (void)std::snprintf(name.data(), name.size(), "%04zu_left.png", k);
    write_png(out / "pictures" / name.data(), picture_of(pair->left));
    (void)std::snprintf(name.data(), name.size(), "%04zu_right.png", k);
    write_png(out / "pictures" / name.data(), picture_of(pair->right));
  }
  return {header.records, header.pairs, static_cast<double>(header.fault_ns) * 1e-9};
}

}  // namespace vergence::tools
