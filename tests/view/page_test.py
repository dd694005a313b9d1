#!/usr/bin/python3
"""Opens pages of `overtet view` in Chromium and looks: does it load by itself, does it do what it says?

usage: page_test.py OVERTET

Exit code 77 where Chromium, its driver or python3-selenium is missing.
"""
import os
import shutil
import subprocess
import sys
import tempfile
import unittest

try:
    from selenium import webdriver
    from selenium.webdriver.common.by import By
    from selenium.webdriver.common.keys import Keys
    from selenium.webdriver.chrome.service import Service
    from selenium.webdriver.support.ui import Select, WebDriverWait
except ImportError:
    webdriver = None

ROOT = os.path.join(os.path.dirname(os.path.realpath(__file__)), "..", "..")
OVERTET = ""


def browser():
    options = webdriver.ChromeOptions()
    for word in ("--headless=new", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
                 "--window-size=1000,700", "--force-device-scale-factor=1"):
        options.add_argument(word)
    options.binary_location = shutil.which("chromium")
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    return webdriver.Chrome(service=Service(shutil.which("chromedriver")), options=options)


class Page(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        surface, cls.mesh = cls.file("worm.off"), cls.file("worm.vtu")
        subprocess.run([os.path.join(ROOT, "scripts", "make_sample"), surface], check=True)
        for words in (["mesh", surface, "-o", cls.mesh], ["view", cls.mesh, "-o", cls.file("tets.html")],
                      ["view", surface, "-o", cls.file("surface.html")]):
            subprocess.run([OVERTET, *words, "--quiet"], check=True)
        cls.driver = browser()

    @classmethod
    def tearDownClass(cls):
        cls.driver.quit()
        cls.folder.cleanup()

    @classmethod
    def file(cls, name):
        return os.path.join(cls.folder.name, name)

    def open(self, name):
        self.driver.get_log("browser")
        self.driver.get_log("performance")
        self.driver.get("file://" + self.file(name))
        WebDriverWait(self.driver, 60).until(
            lambda d: d.find_element(By.TAG_NAME, "html").get_attribute("data-ready") == "yes")

    def script(self, words):
        return self.driver.execute_script("return " + words)

    def picture(self):
        self.script("overtet.frame()")
        return self.driver.get_screenshot_as_png()

    def slide(self, name, value):
        self.driver.execute_script(
            "const s = document.getElementById(arguments[0]); s.value = arguments[1];"
            "s.dispatchEvent(new Event('input'));", name, value)

    def test_it_loads_by_itself(self):
        for name in ("tets.html", "surface.html"):
            self.open(name)
            self.assertEqual([e for e in self.driver.get_log("browser") if e["level"] in ("SEVERE", "WARNING")], [])
            requests = [e["message"] for e in self.driver.get_log("performance") if "requestWillBeSent\"" in e["message"]]
            others = [r for r in requests if "\"url\":\"file://" not in r and "\"url\":\"data:" not in r]
            self.assertEqual(others, [])
            self.assertLess(len([r for r in requests if "\"url\":\"file://" in r]), 2)

    def test_the_cutting_plane_changes_the_picture(self):
        self.open("tets.html")
        whole, all_of_it = self.picture(), self.script("overtet.shown()")
        self.slide("cut", .5)
        half = self.picture()
        self.assertNotEqual(half, whole)
        self.assertNotEqual(self.script("overtet.shown()"), all_of_it)
        self.driver.find_element(By.ID, "scene").send_keys(",")
        self.assertNotEqual(self.picture(), half)
        self.slide("cut", 0)
        self.slide("cut", 1)
        self.assertEqual(self.script("overtet.shown()"), all_of_it)

    def test_layers_can_be_pulled_apart(self):
        self.open("tets.html")
        together = self.picture()
        self.slide("apart", .7)
        self.assertNotEqual(self.picture(), together)
        self.assertIn("2 layers", self.driver.find_element(By.ID, "legend").text)

    def test_tets_can_be_shrunken_and_chosen_by_angle(self):
        self.open("tets.html")
        before = self.script("overtet.shown()")
        self.slide("shrink", .2)
        self.assertGreater(self.script("overtet.shown()"), before)
        self.slide("shrink", 0)
        self.slide("worse", 20)
        self.assertLess(self.script("overtet.shown()"), before)

    def test_a_picked_element_says_what_it_is(self):
        self.open("tets.html")
        for x in range(300, 1000, 20):  # somewhere along the middle there is the worm
            self.driver.execute_script("overtet.pick_at(arguments[0], arguments[1])", x, 330)
            said = self.driver.find_element(By.ID, "picked").text
            if said.startswith("Tet"):
                break
        for word in ("Tet ", "vertices", "dihedral angle", "region", "layers", "boundary triangle", "label", "near ("):
            self.assertIn(word, said)
        self.assertEqual(self.driver.find_element(By.ID, "picked").get_attribute("role"), "status")
        self.open("surface.html")
        self.driver.execute_script("overtet.pick(7)")
        self.assertIn("Face 7: vertices", self.driver.find_element(By.ID, "picked").text)

    def test_colours(self):
        self.open("tets.html")
        select = Select(self.driver.find_element(By.TAG_NAME, "select"))
        pictures = set()
        for option in select.options:
            select.select_by_visible_text(option.text)
            pictures.add(self.picture())
        self.assertGreaterEqual(len(pictures), 4)

    def test_keys_turn_and_zoom(self):
        self.open("tets.html")
        canvas = self.driver.find_element(By.ID, "scene")
        for key in (Keys.ARROW_LEFT, Keys.ARROW_UP, "+", "-"):
            before = self.picture()
            canvas.send_keys(key)
            self.assertNotEqual(self.picture(), before, key)

    def test_many_faces_are_drawn_coarsely_while_they_move_only(self):
        # A thin block of 120 x 120 cells of five tets: 58,560 boundary faces.
        n, path = 120, self.file("block.mesh")
        number = lambda x, y, z: (z * (n + 1) + y) * (n + 1) + x + 1
        with open(path, "w", encoding="ascii") as file:
            file.write(f"MeshVersionFormatted 2\nDimension 3\nVertices\n{2 * (n + 1) ** 2}\n")
            file.writelines(f"{x} {y} {z} 0\n" for z in range(2) for y in range(n + 1) for x in range(n + 1))
            file.write(f"Tetrahedra\n{5 * n * n}\n")
            for y in range(n):
                for x in range(n):
                    c = [number(x + (i & 1), y + (i >> 1 & 1), i >> 2) for i in range(8)]
                    if (x + y) % 2:  # mirrored, so that neighbours have the same diagonals
                        c = [c[i ^ 1] for i in range(8)]
                    for a, b, d, e in ((0, 1, 2, 4), (3, 2, 1, 7), (5, 4, 7, 1), (6, 7, 4, 2), (1, 2, 4, 7)):
                        t = [c[a], c[b], c[d], c[e]]
                        if (x + y) % 2:
                            t[0], t[1] = t[1], t[0]
                        file.write("%d %d %d %d 1\n" % tuple(t))
            file.write("End\n")
        subprocess.run([OVERTET, "view", path, "-o", self.file("block.html"), "--quiet"], check=True)
        self.open("block.html")
        self.assertEqual(self.script("overtet.shown()"), 4 * n * n + 8 * n)
        # Of a picture of 200 x 140: whether there is something, not what colour it has.
        seen = """(moving => {
          overtet.frame(moving);
          const small = new OffscreenCanvas(200, 140).getContext("2d");
          small.drawImage(document.getElementById("scene"), 0, 0, 200, 140);
          return [...small.getImageData(0, 0, 200, 140).data].filter((_, i) => i % 4 === 0).map(x => x < 250 ? 1 : 0);
        })"""
        for cut in (1, .62):
            self.slide("cut", cut)
            moving, still = self.script(seen + "(true)"), self.script(seen + "(false)")
            self.assertGreater(sum(still), 1000)
            self.assertLess(sum(a != b for a, b in zip(moving, still)), .03 * sum(still))
        # What is picked is the same in both.
        picked = []
        for moving in ("true", "false"):
            self.script(f"overtet.frame({moving})")
            self.driver.execute_script("overtet.pick_at(600, 350)")
            picked.append(self.driver.find_element(By.ID, "picked").text)
        self.assertEqual(picked[0], picked[1])
        self.assertIn("Tet ", picked[0])
        # When it has stood still for a moment, it is drawn as it should be.
        width = "document.getElementById('scene').width"
        self.script("overtet.frame(false)")
        wide = self.script(width)
        self.driver.find_element(By.ID, "scene").send_keys(Keys.ARROW_LEFT)
        WebDriverWait(self.driver, 60).until(lambda d: self.script(width) == wide)

    def test_a_cut_shows_what_is_behind_it(self):
        # Whichever way the faces to show are found: tet by tet, or from the lists of the cutting plane.
        self.open("tets.html")
        for axis in ("x", "y", "z"):
            Select(self.driver.find_elements(By.TAG_NAME, "select")[1]).select_by_visible_text(axis)
            for cut in (0, .21, .5, .83, 1):
                self.slide("cut", cut)
                quick = self.script("overtet.shown()")
                self.slide("worse", 89.5)  # all of them are worse, so nothing is left out
                self.assertEqual(self.script("overtet.shown()"), quick, (axis, cut))
                self.slide("worse", 90)
                self.assertEqual(self.script("overtet.shown()"), quick, (axis, cut))

    def test_everything_has_a_name_for_a_screen_reader(self):
        self.open("tets.html")
        for control in self.driver.find_elements(By.CSS_SELECTOR, "input, select, button, canvas, svg"):
            name = control.accessible_name
            self.assertTrue(name, control.get_attribute("outerHTML"))
        self.assertEqual(self.driver.find_element(By.TAG_NAME, "html").get_attribute("lang"), "en")


def main():
    global OVERTET
    if webdriver is None or not shutil.which("chromium") or not shutil.which("chromedriver"):
        print("SKIPPED: pages are not looked at: install chromium, chromium-driver and python3-selenium (scripts/setup --examples)")
        return 77
    OVERTET = os.path.abspath(sys.argv[1])
    result = unittest.TextTestRunner(verbosity=2).run(unittest.defaultTestLoader.loadTestsFromTestCase(Page))
    return 0 if result.wasSuccessful() else 1


if __name__ == "__main__":
    sys.exit(main())
