// Written by references.py, which says what each number means and how it is computed.
#pragma once
#include <array>

namespace genphys::bench::reference {

/// A5 at 10 s, w x y z.
inline constexpr std::array<double, 4> kTopOrientation{-0.5761990762744522, 0.2910532268465503, -0.6120653039965508,
                                                       -0.4567917548361489};
/// A5dz, s; the first flip comes at half of it.
inline constexpr double kFlipPeriod = 8.044580227688387;
/// A3 at 1 s, m.
inline constexpr double kSprung = 0.036339707619322134;
/// B1 at 5 s, x and z of the centre, m.
inline constexpr std::array<double, 2> kPendulum{-0.49000494627759655, -0.09947438174469694};
/// B1 set free at 0.5 s, at 1 s, x and z of the centre, m.
inline constexpr std::array<double, 2> kReleasedPendulum{-1.3923726207827714, -1.6032992072002872};
/// B3 at 2 s, x and z of the second centre, m.
inline constexpr std::array<double, 2> kDoublePendulum{0.11322485725099934, -1.4563756857448187};
/// B4 at 2 s, the centre, m.
inline constexpr std::array<double, 3> kHeavyTop{0.215018039371889, -0.14675319030493164, 0.14909977826943038};
/// B4.steady, rad/s.
inline constexpr double kPrecession = 3.5943510342807805;
/// B5 at 1 s, m.
inline constexpr double kSliderCrank = 0.31424841036068596;
/// C1: a hundredth below what friction 0.5 holds, rad.
inline constexpr double kStickAngle = 0.45963961443038215;
/// C1: a hundredth above, rad.
inline constexpr double kSlipAngle = 0.4676396037632291;
/// C1 above, m/s^2.
inline constexpr double kSlipAcceleration = 0.043783736675834996;
/// C2, m.
inline constexpr double kStopDistance = 2.5484199796126403;
/// C3 at 2 s, m.
inline constexpr double kSlideThenRoll = 11.019367991845057;
/// C19 at 1 s on 15 degrees, m.
inline constexpr double kRollingBall = 0.9067910115913317;
/// C19 at 1 s on 15 degrees, m.
inline constexpr double kRollingCylinder = 0.8463382774852429;
/// C5 for a restitution of 0.5, 0.8, 0.9, s.
inline constexpr std::array<double, 3> kRestTimes{1.3545709229571927, 4.063712768871578, 8.578949178728887};
/// C5 on a slope, x and z from the first touch at 0.8 s, m.
inline constexpr std::array<double, 2> kTiltedBounce{0.8929616921879676, 0.31419208572442997};
/// C5 of two moving spheres at 0.5 s, m.
inline constexpr std::array<double, 3> kFirstSphere{0.650460300357163, -0.5914022335281852, -0.2112930728367757};
/// The other one, m.
inline constexpr std::array<double, 3> kSecondSphere{0.9247698498214185, 0.4957011167640926, 0.15564653641838785};

}  // namespace genphys::bench::reference
