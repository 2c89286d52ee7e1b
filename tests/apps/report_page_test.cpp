#include "apps/report_page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
