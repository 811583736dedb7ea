"""Who comes too close to whom: contacts, times to collision, wrecks, and drivers who brake for what comes at them."""
