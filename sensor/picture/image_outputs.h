// What an image can be written as, each output once: in the table below. The program's options, its help and its
// messages follow from it. To add a kind of file: a <kind>_io.cpp that has its function, a line here, and a test.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sensor/picture/csv_io.h"
#include "sensor/picture/envi_io.h"
#include "sensor/picture/image.h"
#include "sensor/picture/image_io.h"
#include "sensor/picture/preview.h"
#include "sensor/picture/rays_picture.h"

namespace obscura {

/// What an output is told beside its file's name.
struct OutputChoice {
  std::string quantity = "radiance";  ///< of each band: the channels <band>.<quantity>
  std::vector<PixelPlace> pixels;     ///< which pixels, of an output that takes them
};

/// One file to write.
struct OutputJob {
  const std::filesystem::path& file;
  const Image& image;
  const std::string& band;  ///< whose file it is, of an output with one file for each band; else empty
  const OutputChoice& choice;
};

/// A kind of file.
struct OutputFormat {
  std::vector<std::string> extensions;  ///< with the dot, the usual one first
  /// The file appears under its name only when it is whole.
  /// @throws InputError where the image lacks a channel, ResourceError where the file cannot be written
  void (*write)(const OutputJob& job);
};

/// Who asks for an output.
enum class OutputUse {
  image,    ///< every render: the image itself, with all channels
  picture,  ///< a render: something to look at
  other     ///< a render, or an export of an image that was rendered before: for other programs
};

/// One output of an image, in one of several formats.
struct ImageOutput {
  OutputUse use;
  std::string option;       ///< of the program: "--envi"
  std::string placeholder;  ///< of the option's value: "FILE.hdr"
  std::string what;         ///< a line of help
  std::vector<OutputFormat> formats;
  bool one_file_per_band = false;  ///< FILE.png for the first band, FILE.<band>.png for the others
  bool takes_quantity = false;     ///< it obeys OutputChoice::quantity
  bool takes_pixels = false;       ///< it obeys OutputChoice::pixels
  std::string needs = {};          ///< a quantity that each band has to have; empty: none
  /// The second file that it writes, by the name of the first; null: none.
  std::filesystem::path (*second_file)(const std::filesystem::path& file) = nullptr;
};

/// The table. No two outputs share an option.
inline const std::vector<ImageOutput>& image_outputs() {
  static const std::vector<ImageOutput> outputs = {
      {.use = OutputUse::image,
       .option = "--output",
       .placeholder = "IMAGE.exr",
       .what = "Image to write: radiance, error, transmission, temperature ...",
       .formats = {{{".exr"}, [](const OutputJob& job) { write_image(job.file, job.image); }}}},

      {.use = OutputUse::picture,
       .option = "--preview",
       .placeholder = "P.png",
       .what = "Picture to look at",
       .formats = {{{".png"}, [](const OutputJob& job) { write_preview_sheet(job.file, job.image, job.band); }}},
       .one_file_per_band = true},

      {.use = OutputUse::picture,
       .option = "--rays",
       .placeholder = "P.png",
       .what = "Picture of where the rays went, and what asked for them",
       .formats = {{{".png"}, [](const OutputJob& job) { write_png(job.file, rays_picture(job.image)); }}}},

      {.use = OutputUse::other,
       .option = "--envi",
       .placeholder = "FILE.hdr",
       .what = "Header to write, with the bands in FILE.img: ENVI, float32, band sequential",
       .formats = {{{".hdr"}, [](const OutputJob& job) { write_envi(job.file, job.image, job.choice.quantity); }}},
       .takes_quantity = true,
       .second_file = envi_data_file},

      {.use = OutputUse::other,
       .option = "--counts",
       .placeholder = "FILE",
       .what = "The detector's counts in 16 bits, .png or .tif; of several bands FILE.<band>.png ...",
       .formats = {{{".png"}, [](const OutputJob& job) { write_counts(job.file, job.image, job.band + ".counts"); }},
                   {{".tif", ".tiff"},
                    [](const OutputJob& job) { write_counts(job.file, job.image, job.band + ".counts"); }}},
       .one_file_per_band = true,
       .needs = "counts"},

      {.use = OutputUse::other,
       .option = "--csv",
       .placeholder = "FILE.csv",
       .what = "Table to write: one row for each pixel, with all channels",
       .formats = {{{".csv"}, [](const OutputJob& job) { write_csv(job.file, job.image, job.choice.pixels); }}},
       .takes_pixels = true},
  };
  return outputs;
}

/// The format that a file's extension asks for; null where the output has none of it.
const OutputFormat* output_format_of(const ImageOutput& output, const std::filesystem::path& file);

/// ".png or .tif": the usual extension of each format, for messages.
std::string extension_list(const ImageOutput& output);

/// Every file that an output writes under a name, the second files included.
/// @param bands  of the image; none are taken for one whose name does not matter
std::vector<std::filesystem::path> files_of(const ImageOutput& output, const std::filesystem::path& file,
                                            const std::vector<std::string>& bands);

/// Writes them. @throws what OutputFormat::write does; InputError where no format has the file's extension
void write_output(const ImageOutput& output, const std::filesystem::path& file, const Image& image,
                  const OutputChoice& choice);

}  // namespace obscura
