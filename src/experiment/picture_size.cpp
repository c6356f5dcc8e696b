// SPDX-License-Identifier: GPL-3.0-or-later
#include "picture_size.h"

#include "crackle/common/failure.h"
#include "crackle/common/regular_file.h"

#include <fstream>
#include <string_view>

namespace crackle::experiment {

namespace {

using namespace std::string_view_literals;

class Bytes {
public:
  explicit Bytes(const std::filesystem::path& file) : stream_(file, std::ios::binary) {}

  int next() {
    const int byte = stream_.get();
    if (!stream_) fail("ends in its header");
    return byte;
  }
  /// A big-endian number.
  int number(int n_bytes) {
    unsigned value = 0;
    for (int i = 0; i < n_bytes; ++i) value = value << 8 | static_cast<unsigned>(next());
    return static_cast<int>(value);
  }
  void skip(int n_bytes) {
    for (int i = 0; i < n_bytes; ++i) next();
  }
  bool starts_with(std::string_view text) {
    for (const char c : text)
      if (stream_.get() != static_cast<unsigned char>(c)) return false;
    return true;
  }
  void rewind() {
    stream_.clear();
    stream_.seekg(0);
  }

private:
  std::ifstream stream_;
};

/// Markers that begin a frame: SOF0 to SOF15 without those of tables (DHT, JPG, DAC).
bool begins_frame(int marker) {
  return marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
}

std::pair<int, int> jpeg_size(Bytes& bytes) {
  bytes.skip(2);
  for (;;) {
    if (bytes.next() != 0xff) fail("is a damaged JPEG");
    int marker = bytes.next();
    while (marker == 0xff) marker = bytes.next();
    if (marker == 0xda || marker == 0xd9) fail("is a JPEG without a size");
    if (marker == 0x01 || (marker >= 0xd0 && marker <= 0xd7)) continue;  // without a segment
    const int length = bytes.number(2);
    if (begins_frame(marker)) {
      bytes.skip(1);
      const int height = bytes.number(2);
      return {bytes.number(2), height};
    }
    bytes.skip(length - 2);
  }
}

}  // namespace

std::pair<int, int> picture_size(const std::filesystem::path& file) {
  if (!is_taken(file)) fail("there is no such file");
  if (const std::string kind = other_kind(file); !kind.empty()) fail("is {}", kind);
  Bytes bytes(file);
  std::pair<int, int> size{0, 0};
  if (bytes.starts_with("\x89PNG\r\n\x1a\n"sv)) {
    bytes.skip(4);
    if (!bytes.starts_with("IHDR"sv)) fail("is a damaged PNG");
    size.first = bytes.number(4);
    size.second = bytes.number(4);
  } else {
    bytes.rewind();
    if (!bytes.starts_with("\xff\xd8"sv)) fail("is neither PNG nor JPEG");
    bytes.rewind();
    size = jpeg_size(bytes);
  }
  if (size.first <= 0 || size.second <= 0) fail("has no pixels");
  return size;
}

}  // namespace crackle::experiment
