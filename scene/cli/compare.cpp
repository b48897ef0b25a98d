// obscura compare: how far an image is from a reference, channel by channel.
#include "sensor/judge/compare.h"

#include <fmt/format.h>

#include <cstdio>
#include <memory>

#include "commands.h"
#include "console.h"
#include "sensor/picture/image_io.h"

namespace obscura::cli {

Command add_compare(CLI::App& program) {
  struct Arguments {
    std::string image, reference;
  };
  const auto a = std::make_shared<Arguments>();
  CLI::App* app = program.add_subcommand("compare", "Compare an image with a reference, channel by channel");
  app->add_option("image", a->image, "Image")->required()->type_name("IMAGE");
  app->add_option("reference", a->reference, "Reference of the same size")->required()->type_name("REFERENCE");
  app->footer(
      "The image error is the RMS over pixels of (L - L_ref) / max(|L_ref|, 0.05 max |L_ref|).\n"
      "z is the difference over the images' own standard errors: near 1 where they explain it.\n\n"
      "Example:\n"
      "  obscura compare image.exr reference.exr");
  return {app, [a] {
            const Comparison comparison = compare(read_image(a->image), read_image(a->reference));
            fmt::print("{}", comparison.table());
            for (const std::string& name : comparison.only_image) fmt::print("only in {}: {}\n", a->image, name);
            for (const std::string& name : comparison.only_reference) {
              fmt::print("only in {}: {}\n", a->reference, name);
            }
            fmt::print("image error: {:.6g}\n", comparison.image_error());
            return static_cast<int>(kDone);
          }};
}

}  // namespace obscura::cli
