"""Two 45-degree mirrors on an altazimuth mount: optics, a simulated world, the closed loop."""
