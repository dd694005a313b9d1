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
