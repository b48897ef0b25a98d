// The only file that knows OpenImageIO.
#include "sensor/picture/image_io.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <system_error>

#include "sensor/picture/whole_file_io.h"

namespace obscura {
namespace {

namespace fs = std::filesystem;

std::string reason(std::string message, const char* otherwise) {
  while (!message.empty() && (message.back() == '\n' || message.back() == ' ')) message.pop_back();
  return message.empty() ? otherwise : message;
}

// Scanlines from a function that fills `rows` of them, interleaved.
template <class T>
void write_rows(const fs::path& path, const fs::path& shown, const char* format, const OIIO::ImageSpec& spec,
                OIIO::TypeDesc type, const std::function<void(int y, int rows, T* out)>& fill,
                OIIO::Filesystem::IOProxy* memory = nullptr) {
  const auto fail = [&](const std::string& message) {
    throw ResourceError(shown.string(), "cannot be written: " + message,
                        "check the folder, its permissions and the space left");
  };
  const auto output = OIIO::ImageOutput::create(format);
  if (!output) fail(reason(OIIO::geterror(), "the format is not supported"));
  if (memory) output->set_ioproxy(memory);
  if (!output->open(path.string(), spec)) fail(reason(output->geterror(), "it cannot be opened"));

  constexpr int block = 64;
  std::vector<T> pixels(static_cast<std::size_t>(block) * static_cast<std::size_t>(spec.width) *
                        static_cast<std::size_t>(spec.nchannels));
  for (int y = 0; y < spec.height; y += block) {
    const int rows = std::min(block, spec.height - y);
    fill(y, rows, pixels.data());
    if (!output->write_scanlines(y, y + rows, 0, type, pixels.data())) {
      fail(reason(output->geterror(), "writing failed"));
    }
  }
  if (!output->close()) fail(reason(output->geterror(), "closing failed"));
}

void add_metadata(const Metadata& metadata, OIIO::ImageSpec& spec) {
  for (const auto& [key, value] : metadata) {
    if (const auto* number = std::get_if<int>(&value)) {
      spec.attribute(key, *number);
    } else if (const auto* real = std::get_if<double>(&value)) {
      spec.attribute(key, OIIO::TypeDesc::DOUBLE, real);
    } else {
      spec.attribute(key, std::get<std::string>(value));
    }
  }
}

Metadata read_metadata(const OIIO::ImageSpec& spec) {
  Metadata metadata;
  for (const OIIO::ParamValue& value : spec.extra_attribs) {
    const OIIO::TypeDesc type = value.type();
    if (type == OIIO::TypeDesc::STRING) {
      metadata[value.name().string()] = value.get_string();
    } else if (type == OIIO::TypeDesc::INT) {
      metadata[value.name().string()] = value.get_int();
    } else if (type == OIIO::TypeDesc::DOUBLE) {
      metadata[value.name().string()] = *static_cast<const double*>(value.data());
    } else if (type == OIIO::TypeDesc::FLOAT) {
      metadata[value.name().string()] = static_cast<double>(value.get_float());
    }
  }
  return metadata;
}

}  // namespace

void write_image(const fs::path& path, const Image& image) {
  const int channels = static_cast<int>(image.channels().size());
  OIIO::ImageSpec spec(image.columns(), image.rows(), channels, OIIO::TypeDesc::FLOAT);
  spec.channelnames = image.channels();
  spec.attribute("compression", "zip");
  spec.attribute("Software", "obscura " OBSCURA_VERSION);
  spec.attribute("DateTime", "");  // else OpenImageIO adds the clock: the same image is the same bytes
  add_metadata(image.metadata, spec);

  std::vector<std::span<const float>> planes;
  for (const std::string& name : image.channels()) planes.push_back(image.channel(name));
  const auto fill = [&](int y, int rows, float* out) {
    const auto width = static_cast<std::size_t>(image.columns());
    const std::size_t begin = static_cast<std::size_t>(y) * width;
    for (std::size_t i = begin; i < begin + static_cast<std::size_t>(rows) * width; ++i) {
      for (const std::span<const float> plane : planes) *out++ = plane[i];
    }
  };
  write_whole(path, [&](const fs::path& temporary) {
    write_rows<float>(temporary, path, "openexr", spec, OIIO::TypeDesc::FLOAT, fill);
  });
}

Image read_image(const fs::path& path) {
  std::error_code ignored;
  if (!fs::is_regular_file(path, ignored)) {
    throw InputError(path.string(), "no such image", "check the name and the folder");
  }
  const auto input = OIIO::ImageInput::open(path.string());
  if (!input) {
    throw InputError(path.string(), "is not an image: " + reason(OIIO::geterror(), "unknown format"),
                     "give an OpenEXR image");
  }
  const OIIO::ImageSpec spec = input->spec();
  if (spec.deep) throw InputError(path.string(), "is a deep image", "give a flat one");

  Image image(spec.width, spec.height);
  std::vector<std::span<float>> planes;
  for (const std::string& name : spec.channelnames) planes.push_back(image.add(name));
  image.metadata = read_metadata(spec);

  constexpr int block = 64;
  const auto width = static_cast<std::size_t>(spec.width);
  std::vector<float> pixels(block * width * planes.size());
  for (int y = 0; y < spec.height; y += block) {
    const int rows = std::min(block, spec.height - y);
    if (!input->read_scanlines(0, 0, spec.y + y, spec.y + y + rows, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT,
                               pixels.data())) {
      throw InputError(path.string(), "is broken: " + reason(input->geterror(), "reading failed"), "write it again");
    }
    const float* in = pixels.data();
    const std::size_t begin = static_cast<std::size_t>(y) * width;
    for (std::size_t i = begin; i < begin + static_cast<std::size_t>(rows) * width; ++i) {
      for (const std::span<float> plane : planes) plane[i] = *in++;
    }
  }
  return image;
}

namespace {

using FillBytes = std::function<void(int y, int rows, std::uint8_t* out)>;

FillBytes rows_of(const Raster& raster) {
  return [&raster](int y, int rows, std::uint8_t* out) {
    const std::ptrdiff_t row = 3 * static_cast<std::ptrdiff_t>(raster.columns());
    std::copy_n(raster.rgb().begin() + y * row, rows * row, out);
  };
}

OIIO::ImageSpec spec_of(const Raster& raster) {
  return OIIO::ImageSpec(raster.columns(), raster.rows(), 3, OIIO::TypeDesc::UINT8);
}

}  // namespace

void write_png(const fs::path& path, const Raster& raster) {
  write_whole(path, [&](const fs::path& temporary) {
    write_rows<std::uint8_t>(temporary, path, "png", spec_of(raster), OIIO::TypeDesc::UINT8, rows_of(raster));
  });
}

std::vector<std::uint8_t> png_bytes(const Raster& raster) {
  std::vector<std::uint8_t> bytes;
  OIIO::Filesystem::IOVecOutput memory(bytes);
  write_rows<std::uint8_t>("memory.png", "picture", "png", spec_of(raster), OIIO::TypeDesc::UINT8, rows_of(raster),
                           &memory);
  return bytes;
}

void write_counts(const fs::path& path, const Image& image, const std::string& channel) {
  const std::span<const float> counts = image.channel(channel);
  const bool png = path.extension() == ".png";
  OIIO::ImageSpec spec(image.columns(), image.rows(), 1, OIIO::TypeDesc::UINT16);
  spec.channelnames = {"Y"};
  if (!png) spec.attribute("compression", "zip");
  spec.attribute("Software", "obscura " OBSCURA_VERSION);
  spec.attribute("DateTime", "");
  const auto fill = [&](int y, int rows, std::uint16_t* out) {
    const auto width = static_cast<std::size_t>(image.columns());
    const std::size_t begin = static_cast<std::size_t>(y) * width;
    for (std::size_t i = begin; i < begin + static_cast<std::size_t>(rows) * width; ++i) {
      *out++ = static_cast<std::uint16_t>(std::lround(std::clamp(counts[i], 0.0f, 65535.0f)));
    }
  };
  write_whole(path, [&](const fs::path& temporary) {
    write_rows<std::uint16_t>(temporary, path, png ? "png" : "tiff", spec, OIIO::TypeDesc::UINT16, fill);
  });
}

}  // namespace obscura
