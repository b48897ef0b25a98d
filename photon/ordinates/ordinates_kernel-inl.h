// A row of cells along x, all ordinates of an octant: the kernel of the sweep, once per SIMD target.
#if defined(OBSCURA_ORDINATES_KERNEL_TOGGLE) == defined(HWY_TARGET_TOGGLE)  // once per target
#ifdef OBSCURA_ORDINATES_KERNEL_TOGGLE
#undef OBSCURA_ORDINATES_KERNEL_TOGGLE
#else
#define OBSCURA_ORDINATES_KERNEL_TOGGLE
#endif

#include <numbers>

#include "hwy/highway.h"
#include "photon/ordinates/ordinates_row.h"

HWY_BEFORE_NAMESPACE();
namespace obscura::detail::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<double, kGroup>;
using V = hn::Vec<D>;

/// Where lumping is on, corners are the unknowns; else their combinations in which streaming along an axis
/// is 2 + sqrt 2 times a quarter turn.
struct Basis {
  V scale, shift, unscale, unshift;  // to it: (c0, c1 + shift c0), c0 times scale; back likewise
  V inflow0, inflow1;                // what enters, on the first and second unknown of an axis
  V diagonal, turn;
};

HWY_INLINE void to_basis(const Basis& b, V& first, V& second) {
  second = hn::MulAdd(b.shift, first, second);
  first = hn::Mul(b.scale, first);
}
HWY_INLINE void from_basis(const Basis& b, V& first, V& second) {
  second = hn::NegMulAdd(b.unshift, first, second);
  first = hn::Mul(b.unscale, first);
}

/// first + i second and first - i second, of complex numbers (re, im).
HWY_INLINE void turn(V& re0, V& im0, V& re1, V& im1) {
  const V a = re0, b = im0, c = re1, d = im1;
  re0 = hn::Sub(a, d);
  im0 = hn::Add(b, c);
  re1 = hn::Add(a, d);
  im1 = hn::Sub(b, c);
}
/// The inverse, times 2.
HWY_INLINE void turn_back(V& re0, V& im0, V& re1, V& im1) {
  const V a = re0, b = im0, c = re1, d = im1;
  re0 = hn::Add(a, c);
  im0 = hn::Add(b, d);
  re1 = hn::Sub(b, d);
  im1 = hn::Sub(c, a);
}

template <bool kIsotropic>
void run_row(const RowJob& job, int j, int k) {
  const D d;
  const std::size_t lanes = hn::Lanes(d);
  const SweepAngles& angles = *job.angles;
  const SweepArrays& arrays = *job.arrays;
  const int nx = arrays.cells.x;
  const auto ordinates = static_cast<std::size_t>(angles.ordinates);
  const auto moments = static_cast<std::size_t>(angles.moments);
  const int flip = job.octant;
  const int jj = flip & 2 ? arrays.cells.y - 1 - j : j;
  const int kk = flip & 4 ? arrays.cells.z - 1 - k : k;
  double* const face_x = job.face[0] + static_cast<std::size_t>(k * arrays.cells.y + j) * 4 * ordinates;
  HWY_ALIGN double q[8 * kMostOrdinates];
  HWY_ALIGN double psi[8 * kMostOrdinates];
  const V sqrt2 = hn::Set(d, std::numbers::sqrt2), one = hn::Set(d, 1.0), zero = hn::Zero(d), two = hn::Set(d, 2.0);
  const V half_sqrt2 = hn::Set(d, 0.5 * std::numbers::sqrt2);
  const Basis lumped{one, zero, one, zero, two, zero, one, one};
  const Basis linear{sqrt2, one, half_sqrt2, half_sqrt2, hn::Set(d, 4 * std::numbers::sqrt2), two, two, sqrt2};

  for (int i = 0; i < nx; ++i) {
    const int ii = flip & 1 ? nx - 1 - i : i;
    const auto cell = static_cast<std::size_t>((kk * arrays.cells.y + jj) * nx + ii);
    double* const face_y = job.face[1] + static_cast<std::size_t>(k * nx + i) * 4 * ordinates;
    double* const face_z = job.face[2] + static_cast<std::size_t>(j * nx + i) * 4 * ordinates;
    if (job.surfaces) pass_surfaces(job, Vec3i(ii, jj, kk), {face_x, face_y, face_z});
    const double* const source = arrays.source + 8 * moments * cell;
    const V extinction = hn::Set(d, arrays.extinction[cell]);
    const Basis b = arrays.lumped[cell] ? lumped : linear;

    // Sources of all ordinates from their moments.
    if constexpr (!kIsotropic) {
      const double* const to_ordinate =
          angles.to_ordinate.data() + static_cast<std::size_t>(flip) * moments * ordinates;
      for (std::size_t o = 0; o < ordinates; o += lanes) {
        V s0 = zero, s1 = zero, s2 = zero, s3 = zero, s4 = zero, s5 = zero, s6 = zero, s7 = zero;
        for (std::size_t m = 0; m < moments; ++m) {
          const V y = hn::LoadU(d, to_ordinate + m * ordinates + o);
          const double* const s = source + m;
          const auto at = [&](int corner) { return hn::Set(d, s[static_cast<std::size_t>(corner ^ flip) * moments]); };
          s0 = hn::MulAdd(y, at(0), s0);
          s1 = hn::MulAdd(y, at(1), s1);
          s2 = hn::MulAdd(y, at(2), s2);
          s3 = hn::MulAdd(y, at(3), s3);
          s4 = hn::MulAdd(y, at(4), s4);
          s5 = hn::MulAdd(y, at(5), s5);
          s6 = hn::MulAdd(y, at(6), s6);
          s7 = hn::MulAdd(y, at(7), s7);
        }
        const auto put = [&](std::size_t corner, V v) { hn::StoreU(v, d, q + corner * ordinates + o); };
        put(0, s0), put(1, s1), put(2, s2), put(3, s3), put(4, s4), put(5, s5), put(6, s6), put(7, s7);
      }
    }

    V sum[8] = {zero, zero, zero, zero, zero, zero, zero, zero};
    V flux[3] = {zero, zero, zero};
    for (std::size_t o = 0; o < ordinates; o += lanes) {
      const V ax = hn::LoadU(d, angles.inverse_path[0].data() + o);
      const V ay = hn::LoadU(d, angles.inverse_path[1].data() + o);
      const V az = hn::LoadU(d, angles.inverse_path[2].data() + o);
      const V path = hn::Add(hn::Add(ax, ay), az);
      V r[8];
      for (int corner = 0; corner < 8; ++corner) {
        if constexpr (kIsotropic) {
          r[corner] = hn::Mul(hn::Set(d, source[corner ^ flip]), hn::LoadU(d, angles.to_ordinate.data() + o));
        } else {
          r[corner] = hn::LoadU(d, q + static_cast<std::size_t>(corner) * ordinates + o);
        }
      }
      for (int n = 0; n < 8; n += 2) to_basis(b, r[n], r[n + 1]);
      for (const int n : {0, 1, 4, 5}) to_basis(b, r[n], r[n + 2]);
      for (int n = 0; n < 4; ++n) to_basis(b, r[n], r[n + 4]);

      // What enters through the three faces.
      const auto enter = [&](const double* face, V a, int step, int n0, int n1, int n2, int n3) {
        V f[4];
        for (std::size_t c = 0; c < 4; ++c) f[c] = hn::LoadU(d, face + c * ordinates + o);
        to_basis(b, f[0], f[1]);
        to_basis(b, f[2], f[3]);
        to_basis(b, f[0], f[2]);
        to_basis(b, f[1], f[3]);
        const V a0 = hn::Mul(a, b.inflow0), a1 = hn::Mul(a, b.inflow1);
        const int n[4] = {n0, n1, n2, n3};
        for (int c = 0; c < 4; ++c) {
          r[n[c]] = hn::MulAdd(a0, f[c], r[n[c]]);
          r[n[c] + step] = hn::MulAdd(a1, f[c], r[n[c] + step]);
        }
      };
      enter(face_x, ax, 1, 0, 2, 4, 6);
      enter(face_y, ay, 2, 0, 1, 4, 5);
      enter(face_z, az, 4, 0, 1, 2, 3);

      // (s + turns along three axes) is diagonal over complex numbers: pairs along z are re and im.
      for (int n = 0; n < 2; ++n) turn(r[n], r[n + 4], r[n + 2], r[n + 6]);
      for (int n = 0; n < 4; n += 2) turn(r[n], r[n + 4], r[n + 1], r[n + 5]);
      const V s = hn::MulAdd(b.diagonal, path, extinction);
      const V s2 = hn::Mul(s, s);
      for (int n = 0; n < 4; ++n) {
        V beta = az;
        beta = n & 1 ? hn::Sub(beta, ax) : hn::Add(beta, ax);
        beta = n & 2 ? hn::Sub(beta, ay) : hn::Add(beta, ay);
        beta = hn::Mul(beta, b.turn);
        const V scale = hn::Div(hn::Set(d, 0.25), hn::MulAdd(beta, beta, s2));
        const V re = hn::Sub(hn::Mul(r[n], s), hn::Mul(r[n + 4], beta));
        const V im = hn::Add(hn::Mul(r[n], beta), hn::Mul(r[n + 4], s));
        r[n] = hn::Mul(re, scale);
        r[n + 4] = hn::Mul(im, scale);
      }
      for (int n = 0; n < 4; n += 2) turn_back(r[n], r[n + 4], r[n + 1], r[n + 5]);
      for (int n = 0; n < 2; ++n) turn_back(r[n], r[n + 4], r[n + 2], r[n + 6]);

      for (int n = 0; n < 4; ++n) from_basis(b, r[n], r[n + 4]);
      for (const int n : {0, 1, 4, 5}) from_basis(b, r[n], r[n + 2]);
      for (int n = 0; n < 8; n += 2) from_basis(b, r[n], r[n + 1]);

      const auto leave = [&](double* face, int n0, int n1, int n2, int n3) {
        hn::StoreU(r[n0], d, face + o);
        hn::StoreU(r[n1], d, face + ordinates + o);
        hn::StoreU(r[n2], d, face + 2 * ordinates + o);
        hn::StoreU(r[n3], d, face + 3 * ordinates + o);
      };
      leave(face_x, 1, 3, 5, 7);
      leave(face_y, 2, 3, 6, 7);
      leave(face_z, 4, 5, 6, 7);

      if constexpr (kIsotropic) {
        const V weight = hn::LoadU(d, angles.to_moment.data() + o);
        for (int n = 0; n < 8; ++n) sum[n] = hn::MulAdd(weight, r[n], sum[n]);
      } else {
        for (std::size_t n = 0; n < 8; ++n) hn::StoreU(r[n], d, psi + n * ordinates + o);
      }
      if (arrays.flux) {
        V mean = hn::Add(hn::Add(hn::Add(r[0], r[1]), hn::Add(r[2], r[3])),
                         hn::Add(hn::Add(r[4], r[5]), hn::Add(r[6], r[7])));
        for (std::size_t a = 0; a < 3; ++a)
          flux[a] = hn::MulAdd(hn::LoadU(d, angles.current[a].data() + o), mean, flux[a]);
      }
    }

    double* const result = arrays.moments + 8 * moments * cell;
    if constexpr (kIsotropic) {
      for (int n = 0; n < 8; ++n) result[n ^ flip] += hn::GetLane(hn::SumOfLanes(d, sum[n]));
    } else {
      const double* const to_moment = angles.to_moment.data() + static_cast<std::size_t>(flip) * moments * ordinates;
      for (std::size_t m = 0; m < moments; m += lanes) {
        for (std::size_t n = 0; n < 8; n += 4) {
          V t0 = zero, t1 = zero, t2 = zero, t3 = zero;
          for (std::size_t o = 0; o < ordinates; ++o) {
            const V y = hn::LoadU(d, to_moment + o * moments + m);
            const double* const p = psi + n * ordinates + o;
            t0 = hn::MulAdd(y, hn::Set(d, p[0]), t0);
            t1 = hn::MulAdd(y, hn::Set(d, p[ordinates]), t1);
            t2 = hn::MulAdd(y, hn::Set(d, p[2 * ordinates]), t2);
            t3 = hn::MulAdd(y, hn::Set(d, p[3 * ordinates]), t3);
          }
          const auto add = [&](std::size_t corner, V v) {
            double* const to = result + (corner ^ static_cast<std::size_t>(flip)) * moments + m;
            hn::StoreU(hn::Add(hn::LoadU(d, to), v), d, to);
          };
          add(n, t0), add(n + 1, t1), add(n + 2, t2), add(n + 3, t3);
        }
      }
    }
    if (arrays.flux) {
      for (std::size_t a = 0; a < 3; ++a) {
        const double sign = flip >> a & 1 ? -0.125 : 0.125;
        arrays.flux[3 * cell + a] += sign * hn::GetLane(hn::SumOfLanes(d, flux[a]));
      }
    }
  }
}

}  // namespace obscura::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
