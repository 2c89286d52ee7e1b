TEST(SceneRenderer, ScratchesTurnAndTheHighlightStays) {
  // A quarter turn counter-clockwise seen with y up: what was right of the centre comes to lie above it.
  Scene scene = plain(61, 61, 20);
  scene.disc.scratches = 10;
  const SceneRenderer scratched(scene);
  const Picture a = scratched.render_exact(0, 0, at_rest({30, 30}, 0));
  const Picture b = scratched.render_exact(0, 0, at_rest({30, 30}, M_PI / 2));
  double difference = 0;
  for (int y = 0; y < 61; ++y) {
    for (int x = 0; x < 61; ++x) {
      const int right = x - 30, up = 30 - y;
      ASSERT_NEAR(b.at(30 - up, 30 - right), a.at(x, y), 1e-4);
      difference = std::max(difference, std::abs(static_cast<double>(b.at(x, y)) - a.at(x, y)));
    }
  }
  EXPECT_GT(difference, 5);

  scene.disc.scratches = 0;
  scene.disc.highlight = 25;
  const SceneRenderer lit(scene);
  const Picture c = lit.render_exact(0, 0, at_rest({30, 30}, 0));
  const Picture d = lit.render_exact(0, 0, at_rest({30, 30}, 2.1));
  for (std::size_t i = 0; i < c.levels().size(); ++i) ASSERT_EQ(c.levels()[i], d.levels()[i]);
  EXPECT_NEAR(c.at(23, 23), 170 + 25, 0.3);
  EXPECT_LT(c.at(44, 44), 173);
}

TEST(SceneRenderer, DiscPartlyOrFullyOutside) {
  Scene scene = plain(31, 23, 8);
  scene.disc.scratches = 6;
  scene.disc.highlight = 20;
  Scene wide = scene;
  wide.width = 71;
  wide.height = 63;
  const SceneRenderer cut(scene), whole(wide);
  for (const Point c : {Point{0, 0}, {-3.3, 11}, {30.9, 22.2}, {15, -7.6}, {-20, 5}, {38.2, 30.1}}) {
    const Picture a = cut.render_exact(0, 0, at_rest(c, 0.3));
    const Picture b = whole.render_exact(0, 0, at_rest({c.x + 20, c.y + 20}, 0.3));
    for (int y = 0; y < 23; ++y) {
      for (int x = 0; x < 31; ++x) ASSERT_NEAR(a.at(x, y), b.at(x + 20, y + 20), 1e-4);
    }
  }
  const Picture nothing = cut.render_exact(0, 0, at_rest({1e9, -1e9}));
  for (const float level : nothing.levels()) ASSERT_EQ(level, 80.0F);
}

TEST(SceneRenderer, OddSizesAndDepths) {
  for (const auto& [w, h] : {std::pair{1, 1}, {1, 17}, {17, 1}, {33, 7}}) {
    Scene scene = plain(w, h, 3);
    scene.platform.texture_rms = 5;
    scene.marker = MarkerAppearance{{2, 2}, 2};
    scene.lamp = Lamp{{0, 0}, 1};
    const SceneRenderer eight(scene);
    scene.bits = 12;
    const SceneRenderer twelve(scene);
    const Picture a = eight.render_exact(0, 0, at_rest({0.3, 0.4}));
    const Picture b = twelve.render_exact(0, 0, at_rest({0.3, 0.4}));
    ASSERT_EQ(a.width(), w);
    ASSERT_EQ(a.height(), h);
    for (std::size_t i = 0; i < a.levels().size(); ++i) {
      ASSERT_FLOAT_EQ(b.levels()[i], 16 * a.levels()[i]);
    }
  }
}

TEST(SceneRenderer, VignettingAndFlicker) {
  Scene scene = plain(41, 31, 5);
  scene.disc.visible = false;
  scene.vignetting = 0.3;
  const Picture dark = SceneRenderer(scene).render_exact(0, 0, at_rest({}));
  EXPECT_FLOAT_EQ(dark.at(20, 15), 80);
  EXPECT_FLOAT_EQ(dark.at(0, 0), 56);
  EXPECT_FLOAT_EQ(dark.at(40, 30), 56);
  EXPECT_NEAR(dark.at(40, 15), 80 * (1 - 0.3 * 400 / 625), 1e-4);

  scene.vignetting = 0;
  scene.flicker = 0.1;
  scene.flicker_hz = 100;
  const SceneRenderer flickering(scene);
  EXPECT_NEAR(flickering.render_exact(2.5e-3, 0, at_rest({})).at(3, 3), 88, 1e-4);
  // Mean of the sine over the exposure, by brute force.
  const double time = 1.1e-3, exposure = 3e-3;
  double mean = 0;
  for (int k = 0; k < 10000; ++k) {
    mean += 1 + 0.1 * std::sin(2 * M_PI * 100 * (time + exposure * ((k + 0.5) / 10000 - 0.5)));
  }
  EXPECT_NEAR(flickering.render_exact(time, exposure, at_rest({})).at(3, 3), 80 * mean / 10000, 1e-4);
  EXPECT_NEAR(flickering.render_exact(0.3, 0.01, at_rest({})).at(3, 3), 80, 1e-4);  // a whole period
}

TEST(SceneRenderer, LampShinesForItsShareOfTheExposure) {
  Scene scene = plain(41, 31, 5);
  scene.disc.visible = false;
  scene.flicker = 0.5;
  scene.lamp = Lamp{{10, 12}, 6, 230, 20};
  const SceneRenderer renderer(scene);
  for (const double share : {0.0, 0.25, 1.0}) {
    EXPECT_FLOAT_EQ(static_cast<float>(20 + 210 * share),
                    renderer.render_exact(0.0025, 0, at_rest({}), share).at(10, 12));
  }
  EXPECT_THROW(renderer.render_exact(0, 0, at_rest({}), 1.1), std::invalid_argument);
  EXPECT_THROW(renderer.render_exact(0, 0, at_rest({}), NAN), std::invalid_argument);
}

TEST(SceneRenderer, NoiseHasTheStatedMeanAndVariance) {
  for (const int bits : {8, 12}) {
    for (const auto& [read, shot] : {std::pair{1.5, 0.0}, {0.0, 0.05}, {2.0, 0.03}}) {
      Scene scene = plain(400, 300, 5);
      scene.disc.visible = false;
      scene.bits = bits;
      scene.platform.level = 100.3;
      scene.read_noise = read;
      scene.shot_noise = shot;
      const Picture picture = SceneRenderer(scene).render(3, 0, 0, at_rest({}));
      const double scale = std::ldexp(1.0, bits - 8);
      const double n = 400.0 * 300;
      double sum = 0, squares = 0;
      for (const float level : picture.levels()) {
        ASSERT_EQ(level, std::floor(level));
        const double d = level - 100.3 * scale;
        sum += d;
        squares += d * d;
      }
      // Rounding adds 1/12, whatever the depth.
      const double variance = (read * read + shot * 100.3) * scale * scale + 1.0 / 12;
      EXPECT_NEAR(sum / n, 0, 4 * std::sqrt(variance / n)) << bits << " " << read << " " << shot;
      EXPECT_NEAR(squares / n, variance, 4 * variance * std::sqrt(2 / n))
          << bits << " " << read << " " << shot;
    }
  }
}

TEST(SceneRenderer, WithoutNoiseOnlyRounds) {
  Scene scene = plain(61, 45, 13);
  scene.platform.texture_rms = 10;
  const SceneRenderer renderer(scene);
  const Pose pose = at_rest({29.2, 20.6}, 0, {2.3, -0.7});
  const Picture rounded = renderer.render(4, 0, 0, pose);
  const Picture exact = renderer.render_exact(0, 0, pose);
  for (std::size_t i = 0; i < exact.levels().size(); ++i) {
    ASSERT_EQ(rounded.levels()[i], std::floor(exact.levels()[i] + 0.5F));
  }
}

TEST(SceneRenderer, ClipsToTheDepth) {
  Scene scene = plain(41, 31, 8);
  scene.disc.level = 400;
  scene.platform.level = 0;
  scene.read_noise = 3;
  scene.bits = 10;
  const Picture picture = SceneRenderer(scene).render(0, 0, 0, at_rest({20, 15}));
  for (const float level : picture.levels()) ASSERT_TRUE(level >= 0 && level <= 1023);
  EXPECT_EQ(picture.at(20, 15), 1023);
  EXPECT_GT(SceneRenderer(scene).render_exact(0, 0, at_rest({20, 15})).at(20, 15), 1500);
}

TEST(SceneRenderer, FramesDependOnSeedAndIndexAlone) {
  Scene scene = plain(64, 48, 9);
  scene.read_noise = 2;
  const SceneRenderer renderer(scene), again(scene);
  const Pose pose = at_rest({30, 20});
  const auto same = [](const Picture& a, const Picture& b) {
    return std::ranges::equal(a.levels(), b.levels());
  };
  const Picture seventh = renderer.render(7, 0, 0, pose);
  renderer.render(2, 0, 0, pose);
  EXPECT_TRUE(same(seventh, renderer.render(7, 0, 0, pose)));
  EXPECT_TRUE(same(seventh, again.render(7, 0, 0, pose)));
  EXPECT_FALSE(same(seventh, renderer.render(8, 0, 0, pose)));
  EXPECT_FALSE(same(renderer.render(-1, 0, 0, pose), renderer.render(1, 0, 0, pose)));
  scene.seed = 2;
  EXPECT_FALSE(same(seventh, SceneRenderer(scene).render(7, 0, 0, pose)));
}

TEST(SceneRenderer, RefusesPosesAndExposuresThatAreNotNumbers) {
  const SceneRenderer renderer(plain(20, 20, 5));
  EXPECT_THROW(renderer.render_exact(0, 0, at_rest({NAN, 0})), std::invalid_argument);
  EXPECT_THROW(renderer.render_exact(0, 1, at_rest({0, 0}, INFINITY)), std::invalid_argument);
  EXPECT_THROW(renderer.render_exact(0, -1, at_rest({})), std::invalid_argument);
  EXPECT_THROW(renderer.render_exact(NAN, 0, at_rest({})), std::invalid_argument);
}

}  // namespace
}  // namespace tribotrack::vision
