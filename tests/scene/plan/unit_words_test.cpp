// Units in the spellings of CF, WRF, OpenVDB files and people.
#include "scene/plan/unit_words.h"

#include <catch2/catch.hpp>

using namespace obscura::detail;

TEST_CASE("a unit of amount is known in every usual spelling", "[scene][plausible]") {
  for (const char* words : {"kg m-3", "kg/m3", "kg/m^3", "kg m**-3", "kg.m-3", "Kg m^-3", "kg m⁻³", "kg/m³"}) {
    INFO(words);
    const auto unit = amount_unit(words);
    REQUIRE(unit);
    CHECK(unit->per_g_m3 == 1000);
    CHECK_FALSE(unit->share_of_the_air);
  }
  CHECK(amount_unit("g m-3")->per_g_m3 == 1);
  CHECK(amount_unit("mg/m3")->per_g_m3 == 1e-3);
  CHECK(amount_unit("µg m-3")->per_g_m3 == 1e-6);
  for (const char* words : {"kg kg-1", "kg/kg"}) CHECK(amount_unit(words)->share_of_the_air);
  for (const char* words : {"", "1", "1/m", "m-1", "K", "kg", "kg m-2", "cm-3"}) CHECK_FALSE(amount_unit(words));
}

TEST_CASE("a scale of temperature is known in every usual spelling", "[scene][plausible]") {
  for (const char* words : {"K", "kelvin", "Kelvin", "degrees_K", "degK"})
    CHECK(kelvin_scale(words) == KelvinScale{1, 0});
  for (const char* words : {"degC", "C", "celsius", "Celsius", "deg_C", "degree_Celsius", "degrees Celsius", "°C"})
    CHECK(kelvin_scale(words) == KelvinScale{1, 273.15});
  CHECK(kelvin_scale("degF")->offset_K == Approx(255.372));
  for (const char* words : {"", "degrees_north", "kg", "m"}) CHECK_FALSE(kelvin_scale(words));
}
