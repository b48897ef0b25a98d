// How emission lays out its random numbers; a word of scene files too.
#pragma once

namespace obscura {

/// stratified: a regular mesh modulated by a random law, so that batches are independent replicas;
/// regular: the mesh alone, without a standard error; random: independent numbers.
enum class Directions { stratified, regular, random };

}  // namespace obscura
