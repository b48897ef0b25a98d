// How emission lays out its random numbers; a word of scene files too.
#pragma once

namespace obscura {

/// stratified: an even sequence of points, scrambled anew for each batch, so that batches are independent replicas;
/// regular: the same sequence unscrambled, which has no standard error; random: independent numbers.
enum class Directions { stratified, regular, random };

}  // namespace obscura
