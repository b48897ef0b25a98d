// The table of outputs: every entry writes the files that it says.
#include "sensor/picture/image_outputs.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <set>

#include "octree/base/error.h"
#include "photon/spot/spot.h"
#include "tests/support/scratch_folder.h"

using namespace obscura;
using obscura::test::ScratchFolder;

namespace {

// Two bands with all that any output wants.
Image example() {
  Image image(8, 6);
  float value = 1;
  for (const char* band : {"lwir", "mwir"}) {
    for (const char* quantity : {".radiance", ".error", ".transmission", ".temperature", ".counts"}) {
      for (float& v : image.add(std::string(band) + quantity)) v = value += 0.25f;
    }
  }
  std::ranges::fill(image.add("rays.N"), 4.0f);
  std::ranges::fill(image.add("rays.criterion"), static_cast<float>(Criterion::radiance));
  return image;
}

const ImageOutput& output_of(const std::string& option) {
  const auto found = std::ranges::find(image_outputs(), option, &ImageOutput::option);
  REQUIRE(found != image_outputs().end());
  return *found;
}

}  // namespace

TEST_CASE("every output writes, in every format, exactly the files that it names", "[sensor][image_outputs]") {
  const Image image = example();
  std::set<std::string> options;
  for (const ImageOutput& output : image_outputs()) {
    INFO(output.option);
    CHECK(options.insert(output.option).second);
    CHECK(!output.what.empty());
    for (const OutputFormat& format : output.formats) {
      for (const std::string& extension : format.extensions) {
        INFO(extension);
        const ScratchFolder folder("outputs");
        const auto file = folder / ("a" + extension);
        CHECK(output_format_of(output, file) == &format);
        OutputChoice choice;
        choice.pixels = {{0, 0}, {7, 5}};
        write_output(output, file, image, choice);
        const auto files = files_of(output, file, band_names(image));
        CHECK(files.front() == file);
        CHECK(folder.file_count() == files.size());
        for (const auto& written : files) CHECK(std::filesystem::file_size(written) > 0);
      }
    }
  }
}

TEST_CASE("an output with one file for each band names the others after their bands", "[sensor][image_outputs]") {
  const auto names = [](const std::string& option, const char* file) {
    std::vector<std::string> result;
    for (const auto& path : files_of(output_of(option), file, {"lwir", "mwir"})) result.push_back(path.string());
    return result;
  };
  CHECK(names("--counts", "x/c.tif") == std::vector<std::string>{"x/c.tif", "x/c.mwir.tif"});
  CHECK(names("--envi", "x/e.hdr") == std::vector<std::string>{"x/e.hdr", "x/e.img"});
  CHECK(names("--csv", "t.csv") == std::vector<std::string>{"t.csv"});
  CHECK(files_of(output_of("--preview"), "p.png", {}).size() == 1);
}

TEST_CASE("a file of no format that the output has is refused with all that it has", "[sensor][image_outputs]") {
  const ScratchFolder folder("outputs");
  const ImageOutput& counts = output_of("--counts");
  CHECK(extension_list(counts) == ".png or .tif");
  CHECK(extension_list(output_of("--output")) == ".exr");
  CHECK(output_format_of(counts, "c.jpg") == nullptr);
  CHECK_THROWS_WITH(write_output(counts, folder / "c.jpg", example(), {}),
                    Catch::Contains("--counts") && Catch::Contains("does not end in .png or .tif"));
  CHECK(folder.file_count() == 0);
}
