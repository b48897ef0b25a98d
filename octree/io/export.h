// Volumes to files that other tools open, and what the same voxels would take in their memory.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>

#include "octree/source/voxels.h"
#include "octree/tree/octree.h"

namespace obscura {

struct VdbOptions {
  bool half = false;                            ///< store values as 16-bit floats
  std::map<std::string, std::string> metadata;  ///< of the file
};

/// Writes every channel as an OpenVDB fog volume of floats: active where it isn't 0, background 0,
/// uniform cubes as tiles, voxel centres at integer index coordinates. World units are metres.
/// The file appears under its name only when it is whole; an existing file is replaced.
/// @throws ResourceError where it can't be written.
void write_vdb(const std::filesystem::path& file, const VoxelStream& stream, const VdbOptions& options = {});
void write_vdb(const std::filesystem::path& file, const Octree& octree, const VdbOptions& options = {});

/// What the voxels of a stream take in memory as OpenVDB and NanoVDB float grids, found by making
/// them, and how long NanoVDB's conversion from OpenVDB takes.
struct OtherForms {
  std::uint64_t bytes_openvdb = 0;
  std::uint64_t bytes_nanovdb = 0;
  std::uint64_t bytes_nanovdb_fp8 = 0;
  double seconds_nanovdb = 0;
};
OtherForms measure_other_forms(const VoxelStream& stream);

}  // namespace obscura
