// Scenes drawn by other people, for another engine: they run, hold together and end as they do there.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "base/data_file.h"
#include "tests/support/catch.h"
#include "tests/support/joint_gaps.h"
#include "tests/support/scenes.h"
#include "verifier/import_rube.h"
