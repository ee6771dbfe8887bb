#pragma once

// The C++ client of a genphys server, as a whole. Entities, commands, events and errors are the values of the model
// itself (genphys/entity.h, command.h, event.h, status.h): a program that runs a world in its own process and one that
// runs it on a server are written alike.

#include "genphys/client/drive.h"    // IWYU pragma: export
#include "genphys/client/frame.h"    // IWYU pragma: export
#include "genphys/client/options.h"  // IWYU pragma: export
#include "genphys/client/server.h"   // IWYU pragma: export
#include "genphys/client/stats.h"    // IWYU pragma: export
#include "genphys/client/streams.h"  // IWYU pragma: export
#include "genphys/client/world.h"    // IWYU pragma: export
#include "genphys/wire/early_end.h"  // IWYU pragma: export
