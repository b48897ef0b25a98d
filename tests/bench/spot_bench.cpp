// The spot's query against a ray: spots and rays a second through the middles of the pixels of one picture,
// over an empty scene, a plane, terrain smooth and rough, and terrain with a vehicle; time and memory of the index.
#include <cstdio>
#include <ctime>
#include <memory>
#include <string>
#include <vector>

#include "photon/spot/spot.h"
#include "photon/world/face_index.h"
#include "photon/world/world.h"
#include "sensor/capture/camera.h"
#include "tests/support/shapes_of_surfaces.h"

using namespace obscura;

namespace {

/// Of the processor, which a busy machine does not lengthen; everything but the index is one thread.
double seconds_since(std::clock_t start) { return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC; }

/// [-1, 1]^2 km as 2 n n triangles; `rough` adds hills of the size of faces.
std::shared_ptr<const Mesh> terrain(std::uint32_t n, double rough) {
  return test::sheet_mesh(n, [=](std::uint32_t i, std::uint32_t j) {
    const double x = 2.0 * i / n - 1, y = 2.0 * j / n - 1;
    double z = 20 * std::sin(5 * x) * std::cos(4 * y);
    for (double wave = 30, size = rough; wave < 3000; wave *= 2.7, size *= 0.42)
      z += size * std::sin(wave * x + 0.1 * z) * std::cos(wave * 1.1 * y);
    return Vec3d(1000 * x, 1000 * y, z);
  });
}

void measure(const char* what, std::shared_ptr<const Mesh> mesh) {
  WorldContents contents;
  contents.bands = {Band("grey")};
  Material material;
  material.emissivity = {0.9};
  contents.materials = {material};
  const std::size_t faces = mesh ? mesh->faces.size() : 0;
  if (mesh) {
    Object object;
    object.mesh = std::move(mesh);
    contents.objects = {object};
  }
  const World world(std::move(contents));
  auto start = std::clock();
  const std::size_t bytes = world.surfaces().empty() ? 0 : world.surfaces().index().bytes();
  const double build = seconds_since(start);
  CameraSettings settings;
  settings.position_m = {0, -900, 300};
  settings.look_at_m = {0, 0, 0};
  settings.fov_deg = 30;
  constexpr int side = 512;
  settings.resolution = {side, side};
  const Camera camera(settings);
  SpotQuery query(world, {}, 0);
  double rays = kInfinity, spots = kInfinity;
  int refined = 0, hits = 0;
  std::vector<int> kinds(kCriteria, 0);
  for (int round = 0; round < 3; ++round) {
    hits = 0;
    start = std::clock();
    for (int y = 0; y < side; ++y) {
      for (int x = 0; x < side; ++x) hits += world.surfaces().intersect(*camera.ray(x + 0.5, y + 0.5)).exists();
    }
    rays = std::min(rays, seconds_since(start) / (side * side));
    refined = 0;
    std::fill(kinds.begin(), kinds.end(), 0);
    start = std::clock();
    for (int y = 0; y < side; ++y) {
      for (int x = 0; x < side; ++x) {
        const Criterion found = query(*camera.spot(x, y, x + 1, y + 1));
        refined += found != Criterion::none;
        ++kinds[static_cast<std::size_t>(found)];
      }
    }
    spots = std::min(spots, seconds_since(start) / (side * side));
  }
  std::printf("%-22s %9zu %8.2f %8.1f %8.0f %8.0f %8.2f %9.1f %9.1f ", what, faces, build,
              faces ? double(bytes) / double(faces) : 0.0, 1e9 * rays, 1e9 * spots, spots / rays,
              100.0 * hits / (side * side), 100.0 * refined / (side * side));
  for (std::size_t i = 1; i < kinds.size(); ++i) {
    if (kinds[i] > 0) std::printf(" %s %d", name(static_cast<Criterion>(i)), kinds[i]);
  }
  std::printf("\n");
  std::fflush(stdout);
}

}  // namespace

int main(int count, char** given) {
  const bool quick = count > 1 && std::string(given[1]) == "plane";
  std::printf("%-22s %9s %8s %8s %8s %8s %8s %9s %9s\n", "scene", "faces", "index s", "B/face", "ns ray", "ns spot",
              "spot/ray", "hit %", "refined %");
  measure("empty", nullptr);
  measure("plane", terrain(1, 0));
  if (quick) return 0;
  measure("flat terrain", terrain(707, 0));
  measure("rough terrain", terrain(707, 3));
  measure("coarse terrain", terrain(70, 0));
}
