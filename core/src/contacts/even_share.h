#pragma once
#include <span>

#include "genphys/contact.h"
#include "genphys/contact_memory.h"

namespace genphys {

/// Shares the load of a face (N*s, along its normal) out to its points as a linear pressure does. Three of them tell
/// how much force it passes on and where; of more, a solver leaves the load as its sweeps come by, so that what slides
/// and spins would turn to one side more than to the other. Of all shares with the same force and torques this one has
/// the least squares. Leaves alone points of several faces and such as are ahead, and goes only so far that none pulls.
void ShareEvenly(std::span<const ContactPoint> points, std::span<PointImpulse> impulses);

}  // namespace genphys
